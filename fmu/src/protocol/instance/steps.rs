//! Steps of co-simulation: to the next communication point, or only to the first event.

use super::{Instance, RefusedStep, warning};
use crate::plant::event_indicators::EVENT_INDICATORS;
use crate::plant::simulation::{Kind, Simulation};
use crate::plant::values::input;
use crate::protocol::message::{Category, Message, Status};
use crate::protocol::phases::Phase;
use crate::protocol::refusal::Refusal;

/// Smaller position differences are rounding, m: a host's sum of steps is not a jump of the stroke.
const ROUNDING_M: f64 = 1e-12;

impl Instance {
    /// One step of `h` seconds from the host's time `point`, s; if refused, nothing changes (`fmi2DoStep`).
    ///
    /// # Errors
    /// In the wrong phase; for an invalid step, one beyond the stop time or not starting at the end of the last one; if no
    /// accurate step exists.
    pub fn do_step(&mut self, point: f64, h: f64) -> Result<(), Refusal> {
        self.check_step(point, h)?;
        let stroke = self.advance(point, h)?;
        self.report_step(point, stroke);
        Ok(())
    }

    /// As [`Instance::do_step`], but only to the first event; returns whether there was one. An event is located to within a
    /// billionth of the step, after it. Two events that cancel each other within a step are missed, as is one that the chamber is
    /// so close to at the start of the step that it counts as being there: a start from rest has T = Tw.
    ///
    /// # Errors
    /// As for a step.
    pub fn do_step_to_event(&mut self, point: f64, h: f64) -> Result<bool, Refusal> {
        self.check_step(point, h)?;
        let mut before = self.now.clone();
        before.time = point;
        let sides = self.now.clear_sides();
        let stroke = self.advance(point, h)?;
        let event = match sides {
            Ok(sides) if self.now.has_changed(&sides).unwrap_or(false) => first_event(before, h, &sides),
            _ => None,
        };
        let is_early = event.is_some();
        if let Some(event) = event {
            self.now = event;
        }
        self.report_step(point, stroke);
        Ok(is_early)
    }

    /// Checks that a step, and this one, is allowed now.
    fn check_step(&self, point: f64, h: f64) -> Result<(), Refusal> {
        let advice = match self.phase {
            _ if self.now.kind == Kind::ModelExchange => "only a co-simulation instance makes steps",
            Phase::Event => "call fmi3EnterStepMode first",
            Phase::Terminated => "call fmi2Reset first",
            _ => "call fmi2ExitInitializationMode first",
        };
        self.need(&[Phase::Step], advice)?;
        let bad = |argument, value, expected| Err(Refusal::BadArgument { argument, value, expected });
        if !point.is_finite() {
            return bad("currentCommunicationPoint", point, "a finite time is expected");
        }
        if !(h > 0.0 && h.is_finite()) {
            return bad("communicationStepSize", h, "a positive, finite step is expected");
        }
        let time = self.now.time;
        if (point - time).abs() > (1e-3 * h).max(1e-9 * time.abs().max(1.0).min(point.abs().max(1.0))) {
            return Err(Refusal::WrongPoint { asked: point, reached: time });
        }
        let end = point + h;
        if let Some(stop) = self.now.experiment.stop.filter(|stop| end > stop + 1e-6 * h + 1e-9 * stop.abs().max(1.0)) {
            return Err(Refusal::BeyondStop { end, stop });
        }
        Ok(())
    }

    /// Makes the step; returns the piston's previous position and the host's initial position for the step, m.
    fn advance(&mut self, point: f64, h: f64) -> Result<[f64; 2], Refusal> {
        let reached = self.now.gas.position;
        let requested = if self.now.is_moved_by_velocity() { reached } else { self.now.inputs.value[input::POSITION] };
        let (begin, _) = self.now.plant.limits.apply(requested, 0.0);
        // The host's clock is authoritative, so that rounding in its communication points cannot accumulate.
        let time = std::mem::replace(&mut self.now.time, point);
        if let Err(fault) = self.now.step(h) {
            self.now.time = time;
            let is_repeated = self.refused.is_some_and(|step| (step.point, step.h) == (point, h));
            self.refused = Some(RefusedStep { point, h, is_repeated });
            return Err(fault.into());
        }
        self.refused = None;
        self.outputs = None;
        Ok([reached, begin])
    }

    /// Sends the messages about a step from `point`, s, with a jump of the piston from `reached` to `begin`, m.
    fn report_step(&mut self, point: f64, [reached, begin]: [f64; 2]) {
        let messages = &mut self.messages;
        if self.logs_events && (begin - reached).abs() > ROUNDING_M {
            let text = format!(
                "t = {point} s: the stroke from {reached} m to position = {begin} m was taken up adiabatically"
            );
            messages.push(Message { status: Status::Ok, category: Category::Events, text });
        }
        self.warnings.after_step(&self.now, reached, begin, &mut |text| messages.push(warning(text)));
    }

    /// Resumes steps of co-simulation after event mode (`fmi3EnterStepMode`).
    ///
    /// # Errors
    /// Outside event mode of co-simulation.
    pub fn enter_step(&mut self) -> Result<(), Refusal> {
        if self.now.kind == Kind::ModelExchange {
            return Err(Refusal::NotOffered { what: "this instance is for Model Exchange: it has no step mode" });
        }
        self.need(&[Phase::Event], "enter step mode from event mode")?;
        self.phase = Phase::Step;
        Ok(())
    }
}

/// The part of a step of `h` seconds from `before` up to the first change of these kink sides; `None` if rounding prevents such
/// a partial step.
fn first_event(mut before: Simulation, h: f64, sides: &[Option<bool>; EVENT_INDICATORS]) -> Option<Simulation> {
    let (mut low, mut high) = (0.0, h);
    while high - low > 1e-9 * h {
        let middle = 0.5 * (low + high);
        let mut trial = before.clone();
        let passed = trial.step(middle).is_err() || trial.has_changed(sides).unwrap_or(false);
        if passed { high = middle } else { low = middle }
    }
    before.step(high).ok().map(|()| before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::values::{BASE, Starts, StrokeInput, parameter};
    use chamber::effects::{self, NaturalConvection};

    #[test]
    fn leaving_a_kink_at_which_the_chamber_rests_is_no_event() {
        let mut starts = Starts::default();
        starts.parameters.choices.stroke_input = StrokeInput::Velocity;
        // Free convection: its coefficient has a kink at T = Tw, the state of a chamber at rest.
        starts.parameters.real[BASE + effects::PARAMETER_OFFSETS[NaturalConvection::INDEX]] = 0.25;
        let mut instance = Instance::new(&starts, "{}", Kind::CoSimulation);
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        let velocity = crate::table::index_of(crate::table::variable::Role::Input(input::VELOCITY)).unwrap() as u32;
        instance.set_real(&[velocity], &[-0.1]).unwrap();
        assert_eq!(instance.do_step_to_event(0.0, 0.09), Ok(false));
        // On the way back the gas cools below the wall: the kink is passed once.
        instance.set_real(&[velocity], &[0.1]).unwrap();
        assert_eq!(instance.do_step_to_event(0.09, 0.5), Ok(true));
        let event = instance.time();
        assert!(event > 0.1 && event < 0.58, "{event}");
        assert_eq!(instance.do_step_to_event(event, 0.001), Ok(false));
    }

    #[test]
    fn what_lies_beyond_an_event_that_ends_a_step_is_not_warned_of() {
        let mut starts = Starts::default();
        starts.parameters.choices.stroke_input = StrokeInput::Velocity;
        starts.parameters.real[parameter::STROKE] = 0.11;
        starts.inputs[input::VELOCITY] = 1.0;
        let mut instance = Instance::new(&starts, "{}", Kind::CoSimulation);
        instance.enter_initialization().unwrap();
        let velocity = crate::table::index_of(crate::table::variable::Role::Input(input::VELOCITY)).unwrap() as u32;
        instance.exit_initialization().unwrap();
        instance.set_real(&[velocity], &[1.0]).unwrap();
        assert_eq!(instance.do_step_to_event(0.0, 0.1), Ok(true));
        let texts: Vec<String> = instance.messages().into_iter().map(|message| message.text).collect();
        let text = format!("t = {} s: the piston is pushed beyond its stroke", instance.time());
        assert!((instance.time() - 0.01).abs() < 1e-9, "{}", instance.time());
        assert!(texts.len() == 1 && texts[0].starts_with(&text), "{texts:?}");
    }
}
