//! Subsampled channels, which the `exr` crate refuses when it reads a header and can decompress nevertheless.

use ::exr::prelude::Vec2;

/// What is read of a header of subsampled channels.
pub(super) struct Unsampled {
    /// The file with every channel's sampling as 1 x 1: nothing else of it depends on that.
    pub bytes: Vec<u8>,
    /// The sampling of every channel of every part.
    pub sampling: Vec<Vec<Vec2<usize>>>,
}

/// The file as the crate reads it, where channels are subsampled; `None` where none is, or for a header that makes no sense: the crate
/// then says why.
pub(super) fn unsampled(bytes: &[u8]) -> Option<Unsampled> {
    let mut sampling = Vec::new();
    let mut places = Vec::new();
    let is_multi_part = bytes.get(5)? & 0x10 != 0;
    let mut at = 8;
    loop {
        let mut part = Vec::new();
        while *bytes.get(at)? != 0 {
            at = after_text(bytes, at)?;
            let kind = bytes.get(at..after_text(bytes, at)? - 1)?;
            at += kind.len() + 1;
            let size = usize::try_from(number(bytes, at)?).ok()?;
            let value = at + 4;
            at = value.checked_add(size)?;
            if kind == b"chlist" {
                let mut channel = value;
                while channel < at && *bytes.get(channel)? != 0 {
                    // Type, whether it is perceptually linear, and three bytes of nothing come before.
                    let place = after_text(bytes, channel)? + 8;
                    let step = |offset: usize| usize::try_from(number(bytes, place + offset)?).ok();
                    let step = Vec2(step(0)?, step(4)?);
                    if step != Vec2(1, 1) {
                        places.push(place);
                    }
                    part.push(step);
                    channel = place + 8;
                }
            }
        }
        sampling.push(part);
        at += 1;
        if !is_multi_part || *bytes.get(at)? == 0 {
            break;
        }
    }
    if places.is_empty() {
        return None;
    }
    let mut bytes = bytes.to_vec();
    let one = [1, 0, 0, 0, 1, 0, 0, 0];
    places
        .into_iter()
        .try_for_each(|place| bytes.get_mut(place..place + 8).map(|value| value.copy_from_slice(&one)))?;
    Some(Unsampled { bytes, sampling })
}

/// Behind the zero that ends a text.
fn after_text(bytes: &[u8], at: usize) -> Option<usize> {
    let length = bytes.get(at..)?.iter().take(256).position(|&byte| byte == 0)?;
    Some(at + length + 1)
}

fn number(bytes: &[u8], at: usize) -> Option<i32> {
    Some(i32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}
