//! Steps of co-simulation: to the next communication point, or no further than to the first event.

use super::{Instance, warning};
use crate::plant::simulation::Kind;
use crate::plant::values::input;
use crate::protocol::message::{Category, Message, Status};
use crate::protocol::phases::Phase;
use crate::protocol::refusal::Refusal;

impl Instance {
    /// `fmi2DoStep`.
    ///
    /// # Errors
    /// Out of order; a step of no use, beyond the stop time, from another point than the last one's end; no accurate step.
    pub fn do_step(&mut self, point: f64, h: f64) -> Result<(), Refusal> {
        self.need(&[Phase::Step], "call fmi2ExitInitializationMode first; only a co-simulation instance makes steps")?;
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
        let by_velocity = self.now.is_moved_by_velocity();
        let reached = self.now.gas.position;
        let said = if by_velocity { reached } else { self.now.inputs.value[input::POSITION] };
        let (begin, _) = self.now.plant.limits.apply(said, 0.0);
        // The host's clock counts: rounding in its communication points cannot add up.
        self.now.time = point;
        if let Err(fault) = self.now.step(h) {
            self.now.time = time;
            return Err(fault.into());
        }
        self.outputs = None;
        let messages = &mut self.messages;
        if self.tells_events && begin != reached {
            let text = format!(
                "t = {point} s: the stroke from {reached} m to position = {begin} m was taken up adiabatically"
            );
            messages.push(Message { status: Status::Ok, category: Category::Events, text });
        }
        self.warnings.after_step(&self.now, reached, begin, &mut |text| messages.push(warning(text)));
        Ok(())
    }

    /// As [`Instance::do_step`], but no further than to the first event; whether there was one. An event is located to a
    /// billionth of the step, on its far side.
    ///
    /// # Errors
    /// As for a step.
    pub fn do_step_to_event(&mut self, point: f64, h: f64) -> Result<bool, Refusal> {
        let mut before = self.now.clone();
        before.time = point;
        let sides = self.now.signs();
        self.do_step(point, h)?;
        let (Ok(sides), Ok(after)) = (sides, self.now.signs()) else { return Ok(false) };
        if sides == after {
            return Ok(false);
        }
        let (mut low, mut high) = (0.0, h);
        while high - low > 1e-9 * h {
            let middle = 0.5 * (low + high);
            let mut trial = before.clone();
            let passed = trial.step(middle).is_err() || trial.signs().is_ok_and(|there| there != sides);
            if passed { high = middle } else { low = middle }
        }
        // The whole step was possible, and so is its part, but for rounding: then the step ends where it was to end.
        if before.step(high).is_err() {
            return Ok(false);
        }
        self.now = before;
        self.outputs = None;
        self.warnings.lose_track();
        Ok(true)
    }

    /// `fmi3EnterStepMode`.
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
