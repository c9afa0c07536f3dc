//! Whether effects are true as often as their stated probabilities say: the reliability diagram (G. W. Brier, Mon. Weather Rev.
//! 78 (1950) 1; A. H. Murphy and R. L. Winkler, Appl. Stat. 26 (1977) 41).

use report::{Axis, Chart, Colour, Error, Mark, Series};
use std::fmt::Write;

/// Bounds of the classes of stated probability.
const BOUNDS: [f64; 9] = [0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 0.99, 1.0 + 1e-9];

/// An effect's stated probability, and whether it was in the rig.
pub type Statement = (f64, bool);

/// A class of statements.
struct Class {
    count: usize,
    /// Mean stated probability.
    stated: f64,
    /// Fraction that was true.
    true_share: f64,
}

impl Class {
    /// Half width of that fraction's 95 % interval.
    fn half_width(&self) -> f64 {
        let n = self.count as f64;
        // Agresti and Coull (1998): add two true and two false ones.
        let share = (self.true_share * n + 2.0) / (n + 4.0);
        1.96 * (share * (1.0 - share) / (n + 4.0)).sqrt()
    }
}

fn classes(statements: &[Statement]) -> Vec<Class> {
    let within = |bounds: &[f64]| {
        let part: Vec<&Statement> = statements.iter().filter(|(p, _)| (bounds[0]..bounds[1]).contains(p)).collect();
        let mean = |of: &dyn Fn(&Statement) -> f64| part.iter().map(|s| of(s)).sum::<f64>() / part.len() as f64;
        let is_true = |s: &Statement| f64::from(u8::from(s.1));
        (!part.is_empty()).then(|| Class { count: part.len(), stated: mean(&|s| s.0), true_share: mean(&is_true) })
    };
    BOUNDS.windows(2).filter_map(within).collect()
}

/// Writes the section with its table.
pub fn section(out: &mut String, statements: &[Statement]) {
    let squares: f64 = statements.iter().map(|(p, is_true)| (p - f64::from(u8::from(*is_true))).powi(2)).sum();
    let _ = write!(
        out,
        "## Probabilities of the effects\n\n![reliability](diagnosis_reliability.svg)\n\n\
         Every probability of 1 % and more that a diagnosis states of an effect, against the share of those effects that the rig has; \
         {} statements, Brier score {:.4}. Rigs with something outside the list are left out.\n\n\
         | stated, mean | statements | true | 95 % interval |\n|---|---|---|---|\n",
        statements.len(),
        squares / statements.len().max(1) as f64
    );
    for class in classes(statements) {
        let (share, half) = (100.0 * class.true_share, 100.0 * class.half_width());
        let (low, high) = ((share - half).max(0.0), (share + half).min(100.0));
        let _ = writeln!(
            out,
            "| {:.1} % | {} | {share:.1} % | {low:.0} … {high:.0} % |",
            100.0 * class.stated,
            class.count
        );
    }
    out.push('\n');
}

/// The diagram, as SVG.
///
/// # Errors
/// [`Error`]: the drawing failed.
pub fn figure(statements: &[Statement]) -> Result<String, Error> {
    let classes = classes(statements);
    let points: Vec<(f64, f64)> = classes.iter().map(|c| (100.0 * c.stated, 100.0 * c.true_share)).collect();
    let interval = |c: &Class| {
        let (at, share, half) = (100.0 * c.stated, 100.0 * c.true_share, 100.0 * c.half_width());
        [(at, (share - half).max(0.0)), (at, (share + half).min(100.0))]
    };
    Chart {
        title: "Stated probability of an effect, and how often it was there",
        x: Axis::new("stated probability, %").over(0.0, 100.0),
        y: Axis::new("true, %").over(0.0, 100.0),
        series: vec![
            Series {
                points: vec![(0.0, 0.0), (100.0, 100.0)],
                colour: Colour::Pale,
                label: "calibrated",
                mark: Mark::Dashed(1.5),
            },
            Series {
                points: classes.iter().flat_map(interval).collect(),
                colour: Colour::After,
                label: "95 % interval",
                mark: Mark::Segments(1.5),
            },
            Series { points, colour: Colour::After, label: "diagnoses", mark: Mark::Dots(3.5) },
        ],
        size: (460, 400),
        ..Chart::default()
    }
    .draw()
}
