//! Photometric files of lamps: IESNA LM-63, of 1986 to 2002 (ANSI/IESNA LM-63-02, "Standard File Format for the Electronic Transfer of
//! Photometric Data"). Type C, whose vertical angle is that with the axis; what differs around the axis is averaged.

use gnomon_scene::Profile;

/// Most angles of either kind: more than any goniometer has.
const MOST_ANGLES: usize = 10_000;

/// What a file says of a lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct IesFile {
    /// Greatest mean intensity around the axis [cd].
    pub most: f32,
    /// Intensities by the angle with the axis, the greatest as 1.
    pub profile: Profile,
}

impl IesFile {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// One sentence that says what is wrong.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let text = String::from_utf8_lossy(bytes);
        let (tilt, rest) = after_tilt(&text).ok_or("it has no line TILT=, so it is no LM-63 file")?;
        let mut numbers = Numbers { words: rest.split(|c: char| c.is_whitespace() || c == ',') };
        match tilt.trim() {
            "NONE" => {}
            "INCLUDE" => {
                numbers.next("the tilt's geometry")?;
                let pairs = numbers.count("the number of tilt angles")?;
                for _ in 0..2 * pairs {
                    numbers.next("a tilt angle or factor")?;
                }
            }
            _ => return Err("its TILT is neither NONE nor INCLUDE".to_owned()),
        }
        numbers.next("the number of lamps")?;
        numbers.next("the lumens of a lamp")?;
        let mut factor = numbers.next("the candela multiplier")?;
        let rows = numbers.count("the number of vertical angles")?;
        let columns = numbers.count("the number of horizontal angles")?;
        if numbers.next("the photometric type")? != 1.0 {
            return Err("its photometric type is not C (1)".to_owned());
        }
        for what in ["the unit", "the width", "the length", "the height"] {
            numbers.next(what)?;
        }
        factor *= numbers.next("the ballast factor")? * numbers.next("the ballast-lamp factor")?;
        numbers.next("the watts")?;
        let vertical = numbers.angles(rows, "vertical", 180.0)?;
        let horizontal = numbers.angles(columns, "horizontal", 360.0)?;
        // Each column counts by half the way to those beside it.
        let reach = |i: usize| {
            let before = horizontal[i.saturating_sub(1)];
            horizontal[(i + 1).min(columns - 1)] - before
        };
        let whole: f64 = (0..columns).map(reach).sum();
        let mut means = vec![0.0; rows];
        for column in 0..columns {
            let weight = if whole > 0.0 { reach(column) / whole } else { 1.0 / columns as f64 };
            for mean in &mut means {
                *mean += weight * factor * numbers.next("an intensity")?;
            }
        }
        let most = means.iter().copied().fold(0.0, f64::max);
        if !(means.iter().all(|mean| *mean >= 0.0) && most > 0.0 && (most as f32).is_finite()) {
            return Err("its intensities are not numbers of at least 0, one of them above 0".to_owned());
        }
        let at = |angle: f64| {
            let next = vertical.partition_point(|known| *known < angle);
            match (next.checked_sub(1), vertical.get(next)) {
                (_, Some(known)) if *known == angle => means[next],
                (Some(before), Some(known)) => {
                    let share = (angle - vertical[before]) / (known - vertical[before]);
                    means[before] + share * (means[next] - means[before])
                }
                _ => 0.0,
            }
        };
        let last = vertical.last().copied().unwrap_or(0.0);
        let profile = Profile::new(last.to_radians() as f32, |angle| {
            (at(f64::from(angle).to_degrees().min(last)) / most) as f32
        });
        Ok(Self { most: most as f32, profile: profile.ok_or("its vertical angles end at 0")? })
    }
}

/// What follows `TILT=` in its line, and what follows that line.
fn after_tilt(text: &str) -> Option<(&str, &str)> {
    let start = text.lines().find_map(|line| line.trim_start().strip_prefix("TILT="))?;
    // The line is a part of the text: what follows it begins at its end.
    let end = start.as_ptr() as usize + start.len() - text.as_ptr() as usize;
    Some((start, text.get(end..)?))
}

struct Numbers<'a, F: FnMut(char) -> bool> {
    words: std::str::Split<'a, F>,
}

impl<F: FnMut(char) -> bool> Numbers<'_, F> {
    fn next(&mut self, what: &str) -> Result<f64, String> {
        let word =
            self.words.find(|word| !word.is_empty()).ok_or_else(|| format!("it ends before {what}"))?;
        let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| format!("{what} is no number: '{}'", gnomon_messages::quoted(word)))
    }

    fn count(&mut self, what: &str) -> Result<usize, String> {
        let number = self.next(what)?;
        let is_count = number.fract() == 0.0 && (1.0..=MOST_ANGLES as f64).contains(&number);
        is_count.then_some(number as usize).ok_or_else(|| format!("{what} is not from 1 to {MOST_ANGLES}"))
    }

    fn angles(&mut self, count: usize, kind: &str, most: f64) -> Result<Vec<f64>, String> {
        let what = format!("a {kind} angle");
        let angles = (0..count).map(|_| self.next(&what)).collect::<Result<Vec<_>, _>>()?;
        let in_order = angles.windows(2).all(|pair| pair[0] < pair[1]);
        let in_range = angles.iter().all(|angle| (0.0..=most).contains(angle));
        match in_order && in_range {
            true => Ok(angles),
            false => Err(format!("its {kind} angles do not grow from 0 to {most} degrees at most")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A downlight of 100 cd by the cube of the cosine, measured at 0, 30, 60 and 90 degrees in two half planes.
    const DOWNLIGHT: &str = "IESNA:LM-63-2002\r\n[TEST] none\r\nTILT=NONE\r\n1 1000 2 4 2 1 2 0.1 0.1 0\r\n1.0 1.0 10\r\n\
                             0 30 60 90\r\n0, 180\r\n50 32 6 0\r\n50 33 6.5 0\r\n";

    #[test]
    fn a_downlight_is_read() {
        let file = IesFile::parse(DOWNLIGHT.as_bytes()).unwrap();
        assert_eq!(file.most, 100.0);
        let share = |degrees: f32| file.profile.share(degrees.to_radians().cos());
        assert_eq!(share(0.0), 1.0);
        // Between the samples of the profile, 3.9 degrees apart, a kink is cut off: a quarter of that times the change of slope.
        assert!(
            (share(30.0) - 0.65).abs() < 0.014 && (share(60.0) - 0.125).abs() < 0.014,
            "{} {}",
            share(30.0),
            share(60.0)
        );
        assert!((share(15.0) - 0.825).abs() < 0.01 && share(90.0) < 1e-6 && share(120.0) == 0.0);
    }

    #[test]
    fn what_is_wrong_is_one_sentence() {
        for (from, to, words) in [
            ("TILT=NONE", "", "no line TILT="),
            ("TILT=NONE", "TILT=a.tlt", "neither NONE nor INCLUDE"),
            ("4 2 1 2", "4 2 3 2", "not C"),
            ("4 2 1 2", "99999999 2 1 2", "number of vertical angles is not from 1"),
            ("4 2 1 2", "9 2 1 2", "vertical angles do not grow"),
            ("0 30 60 90", "0 60 30 90", "vertical angles do not grow"),
            ("33 6.5 0", "33 x 0", "an intensity is no number: 'x'"),
            ("33 6.5 0", "33", "ends before an intensity"),
            ("50 33", "-500 33", "at least 0"),
            ("2 4 2 1", "0 4 2 1", "above 0"),
        ] {
            let error = IesFile::parse(DOWNLIGHT.replacen(from, to, 1).as_bytes()).unwrap_err();
            assert!(error.contains(words) && !error.contains('\n'), "{to}: {error}");
        }
        let tilted = DOWNLIGHT.replace("TILT=NONE", "TILT=INCLUDE\n1\n2\n0 90\n1 0.9");
        assert!(IesFile::parse(tilted.as_bytes()).is_ok());
    }
}
