/// A number for people: `digits` significant ones (at least 1), whole numbers never rounded before the point, scientific below
/// 0.0001 and from ten million on. `NaN`, `inf` and `-inf` by these words.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return match value {
            value if value.is_nan() => "NaN".to_owned(),
            value if value > 0.0 => "inf".to_owned(),
            _ => "-inf".to_owned(),
        };
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = digits.clamp(1, 17);
    // Rounding may carry into another decade: 9.996 has three digits as 10.0.
    let scientific = format!("{value:.*e}", digits - 1);
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    match exponent {
        Some(exponent) if (-4..7).contains(&exponent) => {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            format!("{value:.decimals$}")
        }
        _ => scientific,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_count_from_the_first_that_is_not_zero() {
        let cases = [
            (0.012_345, "0.0123"),
            (9.996, "10.0"),
            (12_345.6, "12346"),
            (-0.5, "-0.500"),
            (0.0, "0"),
            (0.000_012_34, "1.23e-5"),
            (1.5e7, "1.50e7"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ];
        for (value, text) in cases {
            assert_eq!(significant(value, 3), text);
        }
        assert_eq!(significant(2.0, 0), "2");
    }
}
