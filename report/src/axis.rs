//! An axis of a chart: name with unit, range and ticks.

/// One axis of a chart.
#[derive(Clone, Debug, Default)]
pub struct Axis<'a> {
    /// Quantity and, after a comma, unit.
    pub name: &'a str,
    /// Start and end; `None`: the range of the data.
    pub range: Option<[f64; 2]>,
    /// Whether the scale is logarithmic.
    pub logarithmic: bool,
    /// Ticks with texts, for names instead of numbers.
    pub named: Vec<(f64, String)>,
}

impl<'a> Axis<'a> {
    /// A linear axis over the data.
    pub fn new(name: &'a str) -> Self {
        Self { name, ..Self::default() }
    }

    /// The same axis with this range.
    pub fn over(self, from: f64, to: f64) -> Self {
        Self { range: Some([from, to]), ..self }
    }

    /// Position of a value along the axis: the value, or its logarithm.
    pub(crate) fn position_of(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    /// About `about` ticks for data from `low` to `high`.
    pub(crate) fn ticks(&self, low: f64, high: f64, about: usize) -> Ticks {
        let [from, to] = self.range.unwrap_or([low, high]);
        if !self.named.is_empty() {
            let at = self.named.iter().map(|(at, _)| *at).collect();
            let texts = self.named.iter().map(|(_, text)| text.clone()).collect();
            return Ticks { range: [from, to], at, texts, power: 0 };
        }
        let ticks = if self.logarithmic { decades(from, to) } else { round(from, to, about) };
        match self.range {
            Some(range) => ticks.within([self.position_of(range[0]), self.position_of(range[1])]),
            None => ticks,
        }
    }
}

/// Positions of ticks along an axis, with their texts.
#[derive(Clone, Debug)]
pub(crate) struct Ticks {
    /// Ends of the axis, as positions.
    pub range: [f64; 2],
    /// Positions of the ticks.
    pub at: Vec<f64>,
    /// Texts of the ticks.
    pub texts: Vec<String>,
    /// Power of ten, a multiple of three, that keeps the texts short.
    power: i32,
}

impl Ticks {
    fn within(self, range: [f64; 2]) -> Self {
        let slack = 1e-9 * (range[1] - range[0]);
        let inside = |at: f64| at >= range[0] - slack && at <= range[1] + slack;
        let (at, texts) = self.at.into_iter().zip(self.texts).filter(|(at, _)| inside(*at)).unzip();
        Self { range, at, texts, power: self.power }
    }

    /// The text at a tick.
    pub fn text(&self, position: f64) -> String {
        let near = |at: &f64| (at - position).abs() <= 1e-9 * (self.range[1] - self.range[0]).abs();
        self.at.iter().position(near).map_or(String::new(), |i| self.texts[i].clone())
    }

    /// The axis name, with the power of ten before the unit.
    pub fn name(&self, text: &str) -> String {
        let superscript = |c: char| match c {
            '-' => '⁻',
            digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit.to_digit(10).unwrap_or(0) as usize],
        };
        let power: String = self.power.to_string().chars().map(superscript).collect();
        match text.rsplit_once(", ") {
            Some((name, unit)) if self.power != 0 => {
                format!("{name}, 10{power}{}", if unit == "1" { String::new() } else { format!(" {unit}") })
            }
            _ => text.to_owned(),
        }
    }
}

/// Round numbers with a step of 1, 2 or 5 times a power of ten, which enclose the range.
fn round(low: f64, high: f64, about: usize) -> Ticks {
    let span = if high > low { high - low } else { high.abs().max(1.0) * 0.1 };
    let (low, high) = if high > low { (low, high) } else { (low - 0.5 * span, high + 0.5 * span) };
    let rough = span / about as f64;
    let tens = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].iter().map(|f| f * tens).find(|s| *s >= rough * (1.0 - 1e-9)).unwrap_or(tens);
    let (first, last) = ((low / step + 1e-9).floor(), (high / step - 1e-9).ceil());
    let at: Vec<f64> = (0..=(last - first) as usize).map(|k| (first + k as f64) * step).collect();
    let range = [first * step, last * step];
    let size = range[0].abs().max(range[1].abs());
    let power =
        if size > 0.0 && !(1e-2..1e4).contains(&size) { (size.log10() / 3.0 + 1e-9).floor() as i32 * 3 } else { 0 };
    let scale = 10f64.powi(power);
    let decimals = (-(step / scale).log10() - 1e-9).ceil().max(0.0) as usize;
    let text = |value: &f64| format!("{:.decimals$}", if value.abs() < 0.5 * step { 0.0 } else { value / scale });
    Ticks { range, texts: at.iter().map(text).collect(), at, power }
}

/// 1, 2 and 5 of every decade; only 1 if there are many decades.
fn decades(low: f64, high: f64) -> Ticks {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let of_each: &[f64] = if last - first > 3 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let values: Vec<f64> =
        (first..=last).flat_map(|decade| of_each.iter().map(move |f| f * 10f64.powi(decade))).collect();
    let ends = [low.log10(), high.log10()];
    let ticks = Ticks {
        range: ends,
        at: values.iter().map(|v| v.log10()).collect(),
        texts: values.iter().map(|v| crate::number::digits(*v, 1)).collect(),
        power: 0,
    };
    ticks.within(ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_hold_the_range() {
        for (low, high) in [(0.0, 5.63), (-149.0, 612.3), (1.01e5, 6.06e5), (3.0, 3.0), (-2e-7, 3e-7)] {
            let t = Axis::new("").ticks(low, high, 5);
            assert!(t.range[0] <= low && t.range[1] >= high, "{low} {high} {t:?}");
            assert!(t.at.len() >= 3 && t.at.len() < 14, "{low} {high} {t:?}");
        }
    }

    #[test]
    fn large_and_small_numbers_put_their_power_of_ten_into_the_unit() {
        let t = Axis::new("").ticks(-2.1e5, 4.3e5, 5);
        assert_eq!((t.text(2e5).as_str(), t.name("rate, Pa/s").as_str()), ("200", "rate, 10³ Pa/s"));
        let t = Axis::new("").ticks(0.0, 2.3e-3, 5);
        assert_eq!((t.text(5e-4).as_str(), t.name("share, 1").as_str()), ("0.5", "share, 10⁻³"));
        let t = Axis::new("").ticks(0.0, 900.0, 5);
        assert_eq!((t.text(200.0).as_str(), t.name("residual, Pa").as_str()), ("200", "residual, Pa"));
    }

    #[test]
    fn a_logarithmic_axis_has_ones_twos_and_fives() {
        let axis = Axis { logarithmic: true, ..Axis::new("").over(1.0, 100.0) };
        assert_eq!(axis.ticks(3.0, 40.0, 5).texts, ["1", "2", "5", "10", "20", "50", "100"]);
    }
}
