//! `[test]` of a study file: the fixed values of the push-and-hold test.

use super::section::{Entry, Section};
use crate::error::Error;
use crate::quantity::point::Point;
use crate::quantity::{self, Base};
use crate::study::Varied;
use records::Model;
use report::number::shortest;

/// All fixed values: the model's and the test's.
pub fn read(model: &Model, test: &Section<'_>, varied: &[Varied]) -> Result<Point, Error> {
    let mut base = Point::of_model(model);

    // Reports a misspelt key before reporting the intended one as missing.
    for key in quantity::all().iter().filter_map(|q| q.name.strip_prefix("test.")) {
        test.get(key);
    }
    test.finish()?;

    let varies = |base: Base| varied.iter().any(|v| v.quantity == base as usize);
    let take = |base: &mut Point, quantity: Base| -> Result<bool, Error> {
        let q = &quantity::all()[quantity as usize];
        let key = q.name.trim_start_matches("test.");
        let Some(entry) = test.get(key) else { return Ok(varies(quantity)) };
        let value = entry.finite()?;
        if !q.allowed.contains(value) {
            return Err(entry.because(format!("is {}, but has to be {}", shortest(value), q.allowed)));
        }
        base.set(quantity, value);
        Ok(true)
    };
    for quantity in [Base::InitialPressure, Base::InitialStroke, Base::FinalStroke, Base::PushTime] {
        if !take(&mut base, quantity)? {
            let q = &quantity::all()[quantity as usize];
            let key = q.name.trim_start_matches("test.");
            return Err(test.missing(key, &format!("{} in {}, here or in [vary]", q.doc, q.unit)));
        }
    }
    for flow in [Base::MassFlowIn, Base::MassFlowOut] {
        base.set(flow, 0.0);
        take(&mut base, flow)?;
    }
    for temperature in [Base::InitialTemperature, Base::TemperatureIn] {
        take(&mut base, temperature)?;
    }
    match (take(&mut base, Base::Duration)?, take(&mut base, Base::HoldTimeConstants)?) {
        (true, true) => {
            let entry = test.get("hold_time_constants").or_else(|| test.get("duration_s"));
            let message = "duration_s and hold_time_constants both set the length of the test: keep one of the two";
            return Err(entry.map_or_else(|| test.missing("duration_s", message), |entry| entry.because(message)));
        }
        (false, false) => {
            return Err(test.missing("duration_s", "duration_s or hold_time_constants, here or in [vary]"));
        }
        _ => {}
    }
    Ok(base)
}
