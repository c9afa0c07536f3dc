//! A series of a chart: points, mark and colour, from a palette that colour-blind readers can distinguish (M. Okabe and K. Ito,
//! "Color Universal Design", 2008).

use crate::Error;
use crate::canvas::{Area, Canvas, INK, failed, on, units};
use plotters::prelude::*;

/// Meaning of a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Measured or true: black.
    Ink,
    /// The published method, or the earlier model: vermilion.
    Before,
    /// A better explanation, or the final model: blue.
    After,
    /// Additional data: grey.
    Pale,
}

impl Colour {
    fn rgb(self) -> RGBColor {
        match self {
            Self::Ink => INK,
            Self::Before => RGBColor(196, 78, 0),
            Self::After => RGBColor(0, 114, 178),
            Self::Pale => RGBColor(110, 110, 110),
        }
    }
}

/// How a series is drawn. Sizes in px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    /// A line of this width.
    Line(f64),
    /// A pale line of this width, beneath others.
    Beneath(f64),
    /// A dashed line of this width.
    Dashed(f64),
    /// Discs of this radius.
    Dots(f64),
    /// Rings of this radius.
    Rings(f64),
    /// Triangles of this size.
    Triangles(f64),
    /// Squares; hollow if not filled.
    Squares(f64, bool),
    /// Squares on a corner; hollow if not filled.
    Diamonds(f64, bool),
    /// Pairs of points joined by a line of this width.
    Segments(f64),
}

/// Points with a common style.
#[derive(Clone, Debug)]
pub struct Series<'a> {
    /// The points (x, y), in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Colour of marks and lines.
    pub colour: Colour,
    /// Legend text; empty for no legend entry.
    pub label: &'a str,
    /// How they are drawn.
    pub mark: Mark,
}

/// Draws a series at these points along the axes.
pub(crate) fn draw(
    area: &Area<'_>,
    chart: &mut Canvas<'_, '_>,
    series: &Series<'_>,
    points: Vec<(f64, f64)>,
) -> Result<(), Error> {
    let colour = series.colour.rgb();
    let stroke = |px: f64| ShapeStyle { color: colour.mix(1.0), filled: false, stroke_width: units(px) as u32 };
    match series.mark {
        Mark::Line(px) => {
            chart.draw_series(LineSeries::new(points, stroke(px))).map_err(failed)?;
        }
        Mark::Beneath(px) => {
            let style = ShapeStyle { color: colour.mix(0.35), ..stroke(px) };
            chart.draw_series(LineSeries::new(points, style)).map_err(failed)?;
        }
        Mark::Dashed(px) => {
            let (dash, gap) = (units(6.0), units(4.0));
            chart.draw_series(DashedLineSeries::new(points, dash, gap, stroke(px))).map_err(failed)?;
        }
        Mark::Segments(px) => {
            let parts = points.chunks_exact(2).map(|pair| PathElement::new(pair.to_vec(), stroke(px)));
            chart.draw_series(parts).map_err(failed)?;
        }
        Mark::Dots(_) | Mark::Rings(_) | Mark::Triangles(_) | Mark::Squares(..) | Mark::Diamonds(..) => {
            for p in points {
                for shape in marker(series, on(area, chart, p)) {
                    area.draw(&shape).map_err(failed)?;
                }
            }
        }
    }
    Ok(())
}

/// The polygons or discs of a point's marker.
fn marker<'a>(series: &Series<'_>, at: (i32, i32)) -> Vec<DynElement<'a, SVGBackend<'a>, (i32, i32)>> {
    let colour = series.colour.rgb();
    let outlined = |corners: &[(f64, f64)], filled: bool| {
        let corners: Vec<(i32, i32)> = corners.iter().map(|(x, y)| (at.0 + units(*x), at.1 + units(*y))).collect();
        let fill = if filled { colour } else { WHITE };
        let mut edge = corners.clone();
        edge.push(edge[0]);
        vec![
            Polygon::new(corners, fill.filled()).into_dyn(),
            PathElement::new(edge, INK.stroke_width(units(1.0) as u32)).into_dyn(),
        ]
    };
    match series.mark {
        Mark::Dots(r) => vec![Circle::new(at, units(r), colour.filled()).into_dyn()],
        Mark::Rings(r) => vec![Circle::new(at, units(r), colour.stroke_width(units(1.2) as u32)).into_dyn()],
        Mark::Triangles(r) => vec![TriangleMarker::new(at, units(r), colour.filled()).into_dyn()],
        Mark::Squares(r, filled) => outlined(&[(-r, -r), (r, -r), (r, r), (-r, r)], filled),
        Mark::Diamonds(r, filled) => outlined(&[(0.0, -r), (r, 0.0), (0.0, r), (-r, 0.0)], filled),
        _ => Vec::new(),
    }
}

/// Draws the symbol before a legend entry.
pub(crate) fn key(area: &Area<'_>, series: &Series<'_>, (left, middle): (f64, f64)) -> Result<(), Error> {
    let colour = series.colour.rgb();
    let line = |from: f64, to: f64, px: f64, strength: f64| {
        let ends = [(units(left + from), units(middle)), (units(left + to), units(middle))];
        let color = colour.mix(strength);
        area.draw(&PathElement::new(ends, ShapeStyle { color, filled: false, stroke_width: units(px.max(1.5)) as u32 }))
            .map_err(failed)
    };
    match series.mark {
        Mark::Line(px) | Mark::Segments(px) => line(0.0, 24.0, px, 1.0),
        Mark::Beneath(px) => line(0.0, 24.0, px, 0.35),
        Mark::Dashed(px) => {
            line(0.0, 9.0, px, 1.0)?;
            line(15.0, 24.0, px, 1.0)
        }
        _ => {
            let at = (units(left + 12.0), units(middle));
            for shape in marker(series, at) {
                area.draw(&shape).map_err(failed)?;
            }
            Ok(())
        }
    }
}
