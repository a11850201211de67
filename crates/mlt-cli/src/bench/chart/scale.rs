//! A logarithmic axis.

/// Maps values to positions, the logarithm linearly.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogScale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl LogScale {
    /// An axis that holds all `values` (above zero) with a little room, from position `from` to position `to`.
    pub(super) fn new(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let (low, high) = values
            .filter(|value| *value > 0.0 && value.is_finite())
            .fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low <= high { (low, high) } else { (0.1, 1.0) };
        let room = (high / low).powf(0.05).max(1.1);
        Self { low: low / room, high: high * room, from, to }
    }

    /// The position of a value.
    pub(super) fn at(&self, value: f64) -> f64 {
        let share = (value / self.low).ln() / (self.high / self.low).ln();
        self.from + share * (self.to - self.from)
    }

    /// Values to write at the axis: powers of ten, or between them as well where those are few.
    pub(super) fn ticks(&self) -> Vec<f64> {
        let decades = (self.low.log10().floor() as i32)..=(self.high.log10().ceil() as i32);
        let all = |steps: &[f64]| -> Vec<f64> {
            let ticks = decades.clone().flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
            ticks.filter(|tick| self.low <= *tick && *tick <= self.high).collect()
        };
        let choices = [&[1.0][..], &[1.0, 3.0], &[1.0, 2.0, 5.0], &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]];
        choices.iter().map(|steps| all(steps)).find(|ticks| ticks.len() >= 4).unwrap_or_else(|| all(choices[3]))
    }
}

/// Three significant digits: `0.0123`, `12.3`, `1.23·10⁻⁵`.
pub(crate) fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".into() } else { "–".into() };
    }
    let text = format!("{value:.2e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    match exponent.parse::<i32>().unwrap_or(0) {
        exponent @ -2..=2 => format!("{value:.*}", (2 - exponent) as usize).replace('-', "−"),
        exponent @ 3..=5 => format!("{:.0}", (value / 10f64.powi(exponent - 2)).round() * 10f64.powi(exponent - 2)),
        exponent => format!("{}·10{}", digits.replace('-', "−"), superscript(exponent)),
    }
}

/// A tick's text: as short as it can be.
pub(super) fn tick(value: f64) -> String {
    match value.log10().floor() as i32 {
        -2..=5 => {
            let text = format!("{value:.4}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        exponent => {
            let mantissa = value / 10f64.powi(exponent);
            let digits = format!("{mantissa:.1}").replace(".0", "");
            let digits = if digits == "1" { String::new() } else { format!("{digits}·") };
            format!("{digits}10{}", superscript(exponent))
        }
    }
}

fn superscript(exponent: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        other => char::from_u32(0x2070 + other.to_digit(10).unwrap_or(0)).unwrap_or(other),
    };
    exponent.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_linear_in_the_logarithm() {
        let scale = LogScale::new([1.0, 100.0].into_iter(), 0.0, 200.0);
        assert!((scale.at(10.0) - 100.0).abs() < 1e-9);
        assert!(scale.at(1.0) > 0.0 && scale.at(100.0) < 200.0);
        assert!(LogScale::new(std::iter::empty(), 0.0, 1.0).at(0.5).is_finite());
        assert!(LogScale::new([0.0, f64::NAN, 3.0].into_iter(), 0.0, 1.0).at(3.0).is_finite());
    }

    #[test]
    fn there_are_always_some_ticks() {
        for (low, high) in [(1.0, 1.0), (1.0, 1.2), (0.003, 0.02), (1e-5, 10.0), (1.0, 30.0)] {
            let ticks = LogScale::new([low, high].into_iter(), 0.0, 1.0).ticks();
            assert!((1..=12).contains(&ticks.len()), "{low} {high}: {ticks:?}");
        }
    }

    #[test]
    fn figures_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (f64::NAN, "–"),
            (0.0123, "0.0123"),
            (0.999_9, "1.00"),
            (-1.05, "−1.05"),
            (12.345, "12.3"),
            (123.4, "123"),
            (12_345.0, "12300"),
            (1.234e-5, "1.23·10⁻⁵"),
            (4.56e7, "4.56·10⁷"),
        ] {
            assert_eq!(significant(value), text);
        }
        for (value, text) in
            [(1.0, "1"), (0.03, "0.03"), (1e-3, "10⁻³"), (3e-4, "3·10⁻⁴"), (1500.0, "1500"), (1e6, "10⁶")]
        {
            assert_eq!(tick(value), text);
        }
    }
}
