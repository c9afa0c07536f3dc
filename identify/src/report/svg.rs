//! Small line charts as inline SVG: axes with units, round ticks, several curves or points.

use std::fmt::Write;

/// One curve.
pub struct Curve<'a> {
    /// Its points.
    pub points: Vec<(f64, f64)>,
    /// Its colour.
    pub colour: &'a str,
    /// What it is, in the legend; empty: not in it.
    pub label: &'a str,
    /// Dots instead of a line.
    pub dots: bool,
}

/// A chart.
pub struct Chart<'a> {
    /// Above it.
    pub title: &'a str,
    /// Horizontal axis with unit.
    pub x: &'a str,
    /// Vertical axis with unit.
    pub y: &'a str,
    /// A band around zero that is noise, in the vertical axis's unit.
    pub band: Option<f64>,
    /// Width and height, px.
    pub size: (f64, f64),
}

const LEFT: f64 = 62.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 24.0;
const BOTTOM: f64 = 40.0;
/// Points beyond this are thinned to the extremes of each column of pixels.
const MOST_POINTS: usize = 700;

impl Chart<'_> {
    /// The chart as an SVG element; nothing where there is nothing to draw.
    pub fn draw(&self, curves: &[Curve]) -> String {
        let Some([left, right, low, high]) = self.range(curves) else { return String::new() };
        let frame = Frame { size: self.size, x: ticks(left, right, 6), y: ticks(low, high, 5) };
        let (width, height) = self.size;
        let mut out =
            format!("<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">", escape(self.title));
        if let Some(band) = self.band {
            let _ = write!(
                out,
                "<rect class=\"band\" x=\"{LEFT}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
                frame.py(band),
                width - LEFT - RIGHT,
                frame.py(-band) - frame.py(band)
            );
        }
        frame.grid(&mut out);
        for c in curves {
            frame.curve(&mut out, c);
        }
        self.words(&mut out, &frame, curves);
        out
    }

    /// What the curves' points and the band extend over: from, to on either axis.
    fn range(&self, curves: &[Curve]) -> Option<[f64; 4]> {
        let finite = |p: &&(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let mut points = curves.iter().flat_map(|c| &c.points).filter(finite).peekable();
        points.peek()?;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        for (x, y) in points {
            range = [range[0].min(*x), range[1].max(*x), range[2].min(*y), range[3].max(*y)];
        }
        if let Some(band) = self.band {
            range = [range[0], range[1], range[2].min(-1.5 * band), range[3].max(1.5 * band)];
        }
        Some(range)
    }

    /// Legend, title and the axes' names.
    fn words(&self, out: &mut String, frame: &Frame, curves: &[Curve]) {
        let (width, height) = self.size;
        let mut at = width - RIGHT - 4.0;
        for c in curves.iter().rev().filter(|c| !c.label.is_empty()) {
            let _ = write!(
                out,
                "<text class=\"legend\" x=\"{at:.1}\" y=\"{:.1}\" fill=\"{}\">{}</text>",
                TOP - 8.0,
                c.colour,
                escape(c.label)
            );
            at -= 6.6 * c.label.chars().count() as f64 + 14.0;
        }
        let _ = write!(
            out,
            "<text class=\"title\" x=\"{LEFT}\" y=\"{:.1}\">{}</text><text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\
             <text class=\"axis\" transform=\"translate(12 {:.1}) rotate(-90)\">{}</text></svg>",
            TOP - 8.0,
            escape(self.title),
            LEFT + (width - LEFT - RIGHT) / 2.0,
            height - 6.0,
            escape(&frame.x.axis(self.x)),
            TOP + (height - TOP - BOTTOM) / 2.0,
            escape(&frame.y.axis(self.y))
        );
    }
}

/// Where numbers lie on the page, px.
struct Frame {
    size: (f64, f64),
    x: Ticks,
    y: Ticks,
}

impl Frame {
    fn px(&self, x: f64) -> f64 {
        let [low, high] = self.x.range;
        LEFT + (x - low) / (high - low) * (self.size.0 - LEFT - RIGHT)
    }

    fn py(&self, y: f64) -> f64 {
        let [low, high] = self.y.range;
        TOP + (high - y) / (high - low) * (self.size.1 - TOP - BOTTOM)
    }

    fn grid(&self, out: &mut String) {
        let (right, bottom) = (self.size.0 - RIGHT, self.size.1 - BOTTOM);
        for y in &self.y.at {
            let at = self.py(*y);
            let _ = write!(
                out,
                "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{right}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/><text class=\"y\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                LEFT - 5.0,
                at + 4.0,
                self.y.label(*y)
            );
        }
        for x in &self.x.at {
            let at = self.px(*x);
            let _ = write!(
                out,
                "<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{TOP}\" y2=\"{bottom}\"/><text class=\"x\" x=\"{at:.1}\" y=\"{:.1}\">{}</text>",
                bottom + 14.0,
                self.x.label(*x)
            );
        }
    }

    fn curve(&self, out: &mut String, c: &Curve) {
        let points = thinned(&c.points).into_iter().map(|(x, y)| (self.px(x), self.py(y)));
        if c.dots {
            for (x, y) in points {
                let _ = write!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.6\" fill=\"{}\"/>", c.colour);
            }
            return;
        }
        let _ = write!(out, "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.3\" points=\"", c.colour);
        for (x, y) in points {
            let _ = write!(out, "{x:.1},{y:.1} ");
        }
        out.push_str("\"/>");
    }
}

/// At most [`MOST_POINTS`], keeping the smallest and largest of each stretch.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let points: Vec<(f64, f64)> = points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    if points.len() <= MOST_POINTS {
        return points;
    }
    let size = points.len().div_ceil(MOST_POINTS / 2);
    points
        .chunks(size)
        .flat_map(|chunk| {
            let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
            let low = chunk.iter().min_by(by_value).copied().unwrap_or_default();
            let high = chunk.iter().max_by(by_value).copied().unwrap_or_default();
            if low.0 <= high.0 { [low, high] } else { [high, low] }
        })
        .collect()
}

/// Round numbers along an axis.
struct Ticks {
    at: Vec<f64>,
    range: [f64; 2],
    step: f64,
}

impl Ticks {
    /// The power of ten, in threes, that keeps labels short.
    fn power(&self) -> i32 {
        let size = self.range[0].abs().max(self.range[1].abs());
        if size > 0.0 && !(1e-2..1e4).contains(&size) { (size.log10() / 3.0).floor() as i32 * 3 } else { 0 }
    }

    fn label(&self, value: f64) -> String {
        let scale = 10f64.powi(self.power());
        let digits = (-(self.step / scale).log10() - 1e-9).ceil().max(0.0) as usize;
        format!("{:.*}", digits, if value == 0.0 { 0.0 } else { value / scale })
    }

    /// The axis's text, its unit times the power of ten.
    fn axis(&self, text: &str) -> String {
        let superscript = |c: char| match c {
            '-' => '⁻',
            digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit.to_digit(10).unwrap_or(0) as usize],
        };
        let power: String = self.power().to_string().chars().map(superscript).collect();
        match text.rsplit_once(", ") {
            Some((name, unit)) if self.power() != 0 => {
                format!("{name}, 10{power}{}", if unit == "1" { String::new() } else { format!(" {unit}") })
            }
            _ => text.to_owned(),
        }
    }
}

fn ticks(low: f64, high: f64, about: usize) -> Ticks {
    let span = if high > low { high - low } else { high.abs().max(1.0) * 0.1 };
    let (low, high) = if high > low { (low, high) } else { (low - 0.5 * span, high + 0.5 * span) };
    let rough = span / about as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].iter().map(|f| f * power).find(|s| *s >= rough).unwrap_or(power);
    let (first, last) = ((low / step).floor(), (high / step).ceil());
    let at: Vec<f64> = (0..=(last - first) as usize).map(|k| (first + k as f64) * step).collect();
    Ticks { range: [first * step, last * step], at, step }
}

/// Text for HTML and SVG.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_hold_the_range() {
        for (low, high) in [(0.0, 5.63), (-149.0, 612.3), (1.01e5, 6.06e5), (3.0, 3.0), (-2e-7, 3e-7)] {
            let t = ticks(low, high, 5);
            assert!(
                t.range[0] <= low && t.range[1] >= high && t.at.len() >= 3 && t.at.len() < 14,
                "{low} {high} {:?}",
                t.at
            );
        }
    }

    #[test]
    fn large_and_small_numbers_put_their_power_of_ten_into_the_unit() {
        let t = ticks(-2.1e5, 4.3e5, 5);
        assert_eq!((t.label(2e5).as_str(), t.axis("rate, Pa/s").as_str()), ("200", "rate, 10³ Pa/s"));
        let t = ticks(0.0, 2.3e-3, 5);
        assert_eq!((t.label(5e-4).as_str(), t.axis("share, 1").as_str()), ("0.5", "share, 10⁻³"));
        let t = ticks(0.0, 900.0, 5);
        assert_eq!((t.label(200.0).as_str(), t.axis("residual, Pa").as_str()), ("200", "residual, Pa"));
    }

    #[test]
    fn thinning_keeps_the_extremes() {
        let mut points: Vec<(f64, f64)> = (0..10_000).map(|k| (f64::from(k), 0.0)).collect();
        points[4321].1 = 7.0;
        points[8765].1 = -3.0;
        let few = thinned(&points);
        assert!(few.len() <= MOST_POINTS + 2);
        assert!(few.contains(&(4321.0, 7.0)) && few.contains(&(8765.0, -3.0)));
    }
}
