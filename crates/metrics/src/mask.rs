use std::str::FromStr;

/// Which pixels of a picture count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    width: u32,
    height: u32,
    inside: Vec<bool>,
}

impl Mask {
    /// Every pixel of a `width` x `height` picture.
    pub fn everything(width: u32, height: u32) -> Self {
        Self { width, height, inside: vec![true; width as usize * height as usize] }
    }

    /// The pixels for which `inside(x, y)` holds.
    pub fn from_fn(width: u32, height: u32, mut inside: impl FnMut(u32, u32) -> bool) -> Self {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self { width, height, inside: pixels.map(|(x, y)| inside(x, y)).collect() }
    }

    /// The pixels inside both a region and `self`. A region that reaches past the picture is cut at its edge.
    pub fn within(&self, region: &Region) -> Self {
        Self::from_fn(self.width, self.height, |x, y| self.contains(x, y) && region.contains(x, y))
    }

    /// Width of the pictures it fits.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height of the pictures it fits.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Whether the pixel counts; false outside the picture.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        x < self.width && y < self.height && self.inside[y as usize * self.width as usize + x as usize]
    }

    /// Row-major indices of the pixels that count.
    pub fn indices(&self) -> impl Iterator<Item = usize> + '_ {
        self.inside.iter().enumerate().filter_map(|(index, &inside)| inside.then_some(index))
    }
}

impl From<gnomon_picture::Mask> for Mask {
    /// The mask that a picture file holds ([`gnomon_picture::read_mask`]): white counts.
    fn from(mask: gnomon_picture::Mask) -> Self {
        let inside = |x, y| mask.inside.get(y as usize * mask.width as usize + x as usize);
        Self::from_fn(mask.width, mask.height, |x, y| inside(x, y).copied().unwrap_or(false))
    }
}

/// A named rectangle of pixels, to measure apart from the rest. Reads from `NAME=X,Y,WIDTHxHEIGHT`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// Name under which its figures appear.
    pub name: String,
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Region {
    /// Whether the pixel lies in the rectangle.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        // Subtraction, because x + width of a huge region would overflow.
        x >= self.x && y >= self.y && x - self.x < self.width && y - self.y < self.height
    }
}

/// A region that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "region '{text}' is not NAME=X,Y,WIDTHxHEIGHT with whole numbers of pixels (as in shadow=10,20,64x32)"
)]
pub struct RegionError {
    text: String,
}

impl FromStr for Region {
    type Err = RegionError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (name, rectangle) = text.split_once('=')?;
            let (corner, size) = rectangle.rsplit_once(',')?;
            let (x, y) = corner.split_once(',')?;
            let (width, height) = size.split_once('x')?;
            let number = |text: &str| text.trim().parse::<u32>().ok();
            let region = Self {
                name: name.trim().to_owned(),
                x: number(x)?,
                y: number(y)?,
                width: number(width)?,
                height: number(height)?,
            };
            (!region.name.is_empty() && region.width > 0 && region.height > 0).then_some(region)
        };
        parse().ok_or_else(|| RegionError { text: text.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_from_a_file_keeps_its_pixels() {
        let mask = gnomon_picture::Mask { width: 2, height: 2, inside: vec![false, true, true, false] };
        let mask = Mask::from(mask);
        assert_eq!(mask.indices().collect::<Vec<_>>(), [1, 2]);
        assert!(mask.contains(1, 0) && !mask.contains(0, 0) && !mask.contains(2, 0));
    }

    #[test]
    fn regions_parse_and_are_cut_at_the_edge() {
        let region: Region = "umbra=2,1,10x1".parse().unwrap();
        assert_eq!(region, Region { name: "umbra".to_owned(), x: 2, y: 1, width: 10, height: 1 });
        let inside: Vec<usize> = Mask::everything(4, 3).within(&region).indices().collect();
        assert_eq!(inside, [6, 7]);
        let huge = Region { name: "all".to_owned(), x: 1, y: 0, width: u32::MAX, height: u32::MAX };
        assert_eq!(Mask::everything(4, 3).within(&huge).indices().count(), 9);
    }

    #[test]
    fn malformed_regions_are_named() {
        for text in
            ["", "a", "a=1,2", "a=1,2,3", "a=1,2,3x", "=1,2,3x4", "a=-1,2,3x4", "a=1,2,0x4", "a=1,2,3x4x5"]
        {
            let error = text.parse::<Region>().unwrap_err();
            assert!(error.to_string().contains(&format!("'{text}'")), "{error}");
        }
    }
}
