//! What is asked of the records of rows that are integrated: peaks, settling, samples for the regression.
//!
//! A record is monotone between the ends of its steps and the places inside where it turns round; with those at hand, all
//! else is a matter of comparing. Only steps that turn, the one in which the record settles, and with the regression
//! those that hold samples are looked into, as many at once as there are lanes.

use crate::advance::{Loadable, Steps};
use crate::course::Course;
use crate::finish::SETTLED;
use crate::general::{General, Row, observe};
use crate::lanes::{Lanes, WIDTH};
use crate::log::{Log, Step};
use crate::look::{Question, look};
use crate::plan::{Plan, Stretch};
use crate::regression::{Part, Records};
use crate::samples::{self, POINTS, SAMPLE_RATE_HZ, Samples};
use chamber::balance::OWN;
use chamber::effects::EffectSet;
use chamber::real::Real;
use pulp::Arch;

/// Index of the record's pressure, Pa, and of the gas's temperature, K, where both are shown.
const PRESSURE: usize = 0;
const TEMPERATURE: usize = 1;
/// Share of its pressure by which a record that stands may tremble.
pub const ROUNDING: f64 = 1e-12;

/// The answers about one row. Pressures of the record, temperatures of the gas.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answer {
    /// Peak from the end of the push on, Pa.
    pub pressure_peak: f64,
    /// When it stands, s of the record.
    pub peak_time: f64,
    /// At the end, Pa.
    pub pressure_final: f64,
    /// Peak from the end of the push on, K.
    pub temperature_peak: f64,
    /// At the end, K.
    pub temperature_final: f64,
    /// From the end of the push until within 1 % for good, s.
    pub settling: f64,
}

/// A step of a row.
#[derive(Clone, Copy, Debug)]
struct Span {
    /// Its row's course, and the stretch it is in.
    course: u32,
    stretch: u32,
    /// Where it stands in the log.
    place: (u32, u32),
    step: Step,
    /// Where each quantity turns round inside: share of its length, and value.
    turn: [Option<(f64, f64)>; 2],
}

impl Span {
    /// Shares and values at which a quantity goes from one monotone part to the next.
    fn corners(&self, quantity: usize) -> impl DoubleEndedIterator<Item = (f64, f64)> {
        let [begin, end] = self.step.shown;
        [Some((0.0, begin[quantity])), self.turn[quantity], Some((1.0, end[quantity]))].into_iter().flatten()
    }
}

/// Working memory, kept from one chunk to the next.
#[derive(Default)]
pub struct Memory {
    spans: Vec<Span>,
    /// Where each course's spans begin; one more for the end.
    begins: Vec<usize>,
    jobs: Vec<Job>,
    records: Records,
}

/// A question about a span.
#[derive(Clone, Copy, Debug)]
struct Job {
    span: usize,
    numbers: [f64; POINTS],
    answer: [f64; POINTS],
}

/// The records of courses that are integrated.
pub struct Reading<'a, const N: usize, const BITS: u32> {
    /// Dispatch.
    pub arch: Arch,
    /// Effects.
    pub set: EffectSet,
    /// The courses, all of one area law.
    pub courses: &'a [Course<'a, N>],
    /// Their steps, from [`seen_from`] on.
    pub log: &'a Log,
    /// Memory to use.
    pub memory: &'a mut Memory,
}

/// The first stretch of a row that is looked into.
pub fn seen_from(plan: &Plan) -> usize {
    plan.window[0].min(plan.hold)
}

/// Whether the record shows a span between the end of the push and the end of the test.
fn shows(plan: &Plan, span: &Span) -> bool {
    (plan.window[0]..plan.window[1]).contains(&(span.stretch as usize))
}

impl<const N: usize, const BITS: u32> Reading<'_, N, BITS> {
    /// The answers about each course; none about those that failed and those without a record.
    pub fn answers(&mut self) -> Vec<Option<Answer>> {
        self.collect();
        self.find_turns();
        let mut answers: Vec<Option<Answer>> = (0..self.courses.len()).map(|course| self.answer(course)).collect();
        self.find_settling(&mut answers);
        answers
    }

    /// All steps of all courses.
    fn collect(&mut self) {
        let Memory { spans, begins, .. } = &mut *self.memory;
        spans.clear();
        begins.clear();
        for (course, c) in self.courses.iter().enumerate() {
            begins.push(spans.len());
            if c.failure.is_some() {
                continue;
            }
            for (stretch, &Steps { from, to, lane }) in c.steps.iter().enumerate().skip(seen_from(c.plan)) {
                for index in from..to {
                    if let Some(step) = self.log.step::<N>(index, lane) {
                        let (course, stretch) = (course as u32, stretch as u32);
                        spans.push(Span { course, stretch, place: (index, lane), step, turn: [None; 2] });
                    }
                }
            }
        }
        begins.push(spans.len());
    }

    /// Answers jobs, as many at once as there are lanes.
    fn work(&mut self, question: impl Fn([Lanes; POINTS]) -> Question) {
        let Memory { spans, jobs, .. } = &mut *self.memory;
        for jobs in jobs.chunks_mut(WIDTH) {
            let mut rows: Vec<Row> = Vec::with_capacity(WIDTH);
            for job in jobs.iter() {
                let span = &spans[job.span];
                let c = &self.courses[span.course as usize];
                rows.push((&c.balance, &c.plan.stretches[span.stretch as usize]));
            }
            let mut system = General::<N, BITS>::new(&rows, self.set);
            let last = jobs.len() - 1;
            for lane in 0..WIDTH {
                system.load(lane, lane.min(last));
            }
            let steps = self.log.pick::<N>(jobs.iter().map(|job| spans[job.span].place));
            let mut numbers = [Lanes::ZERO; POINTS];
            for (k, numbers) in numbers.iter_mut().enumerate() {
                *numbers = Lanes::from_fn(|lane| jobs[lane.min(last)].numbers[k]);
            }
            let answer = look(self.arch, &system, &steps, question(numbers));
            for (lane, job) in jobs.iter_mut().enumerate() {
                job.answer = answer.map(|answer| answer[lane]);
            }
        }
    }

    /// Where the records turn round, and the temperatures.
    fn find_turns(&mut self) {
        let Memory { spans, jobs, .. } = &mut *self.memory;
        jobs.clear();
        for (index, span) in spans.iter().enumerate() {
            for quantity in [PRESSURE, TEMPERATURE] {
                if span.step.turns[quantity] {
                    jobs.push(Job { span: index, numbers: [quantity as f64; POINTS], answer: [0.0; POINTS] });
                }
            }
        }
        self.work(|[quantity, ..]| Question::Turn(quantity));
        let Memory { spans, jobs, .. } = &mut *self.memory;
        for job in jobs {
            spans[job.span].turn[job.numbers[0] as usize] = Some((job.answer[0], job.answer[1]));
        }
    }

    /// The spans of a course.
    fn spans_of(&self, course: usize) -> &[Span] {
        &self.memory.spans[self.memory.begins[course]..self.memory.begins[course + 1]]
    }

    /// What the record of a course shows of the gas before the test: Pa, and its drift, Pa/s.
    fn before(&self, c: &Course<N>) -> [f64; 2] {
        let boundary = c.plan.stretches[0].boundary(0.0);
        let contents = c.balance.contents(&boundary, &c.initial);
        let own = core::array::from_fn(|i| c.initial[OWN + i]);
        let shown = |elapsed| observe(self.set, &c.balance, &boundary, &contents, &own, elapsed)[PRESSURE];
        [shown(0.0), shown(1.0) - shown(0.0)]
    }

    /// All but the settling time.
    fn answer(&self, course: usize) -> Option<Answer> {
        let (c, spans) = (&self.courses[course], self.spans_of(course));
        let plan = c.plan;
        let last = spans.last()?;
        let sign = if plan.expands { -1.0 } else { 1.0 };
        let (mut pressure, mut peak_time) = (f64::NEG_INFINITY, plan.push_end);
        let mut temperature = f64::NEG_INFINITY;
        let mut pressure_final = None;
        if plan.push_end < plan.delay {
            // The record still shows the gas before the test.
            let [before, drift] = self.before(c);
            pressure = sign * (before + drift * plan.push_end);
        }
        for span in spans {
            let stretch = span.stretch as usize;
            if shows(plan, span) {
                for (share, value) in span.corners(PRESSURE) {
                    if sign * value > pressure {
                        pressure = sign * value;
                        peak_time = self.record_time(span, share);
                    }
                }
                pressure_final = Some(span.step.shown[1][PRESSURE]);
            }
            if stretch >= plan.hold {
                for (_, value) in span.corners(TEMPERATURE) {
                    temperature = temperature.max(sign * value);
                }
            }
        }
        let pressure_final = pressure_final.unwrap_or_else(|| {
            let [before, drift] = self.before(c);
            before + drift * plan.duration
        });
        Some(Answer {
            pressure_peak: sign * pressure.max(sign * pressure_final),
            peak_time,
            pressure_final,
            temperature_peak: sign * temperature,
            temperature_final: last.step.shown[1][TEMPERATURE],
            settling: 0.0,
        })
    }

    fn stretch(&self, span: &Span) -> &Stretch {
        &self.courses[span.course as usize].plan.stretches[span.stretch as usize]
    }

    /// Time of the record, s, at a share of a span.
    fn record_time(&self, span: &Span, share: f64) -> f64 {
        let stretch = self.stretch(span);
        stretch.elapsed + stretch.clock.time(span.step.begin + share * span.step.length)
    }

    /// Share of a span at a time of the record, s.
    fn share(&self, span: &Span, time: f64) -> f64 {
        let stretch = self.stretch(span);
        (stretch.clock.at(time - stretch.elapsed) - span.step.begin) / span.step.length
    }

    /// When the records come within 1 % of their ends for good.
    fn find_settling(&mut self, answers: &mut [Option<Answer>]) {
        let mut jobs = core::mem::take(&mut self.memory.jobs);
        jobs.clear();
        for (course, answer) in answers.iter_mut().enumerate() {
            let Some(answer) = answer else { continue };
            let band = SETTLED * (answer.pressure_peak - answer.pressure_final).abs();
            let band = band.max(ROUNDING * answer.pressure_final.abs());
            let plan = self.courses[course].plan;
            // From the end back to the last corner outside, and the corner after it.
            let mut later = None;
            let seen = self.spans_of(course).iter().enumerate().rev().filter(|(_, span)| shows(plan, span));
            let mut corners =
                seen.flat_map(|(index, span)| span.corners(PRESSURE).rev().map(move |corner| (index, span, corner)));
            let outside = corners.find(|&(index, _, (share, value))| {
                let outside = (value - answer.pressure_final).abs() > band;
                if !outside {
                    later = Some((index, share));
                }
                outside
            });
            let Some((index, span, (share, _))) = outside else { continue };
            match later {
                Some((of, end)) if of == index => {
                    let numbers = [share, end, answer.pressure_final, band];
                    jobs.push(Job { span: self.memory.begins[course] + index, numbers, answer: [0.0; POINTS] });
                }
                _ => answer.settling = (self.record_time(span, share) - plan.push_end).max(0.0),
            }
        }
        self.memory.jobs = jobs;
        self.work(|[outside, later, value, band]| Question::Enter { between: [outside, later], value, band });
        for job in &self.memory.jobs {
            let span = &self.memory.spans[job.span];
            let push_end = self.courses[span.course as usize].plan.push_end;
            if let Some(answer) = &mut answers[span.course as usize] {
                answer.settling = (self.record_time(span, job.answer[0]) - push_end).max(0.0);
            }
        }
    }

    /// The first sample of each record that counts: the larger of those beside the peak.
    fn first_samples(&mut self, answers: &[Option<Answer>]) -> Vec<Option<f64>> {
        let mut jobs = core::mem::take(&mut self.memory.jobs);
        jobs.clear();
        let mut firsts: Vec<Option<f64>> = Vec::with_capacity(answers.len());
        for (course, answer) in answers.iter().enumerate() {
            let push_end = samples::from(self.courses[course].plan.push_end);
            let after = answer.map(|answer| samples::from(answer.peak_time).max(push_end));
            firsts.push(after);
            let Some(after) = after.filter(|after| *after > push_end) else { continue };
            for number in [after - 1.0, after] {
                let time = number / SAMPLE_RATE_HZ;
                let spans = self.spans_of(course);
                let holds = |span: &Span| time <= self.record_time(span, 1.0);
                let index = spans.iter().position(holds).unwrap_or(spans.len() - 1);
                let share = self.share(&spans[index], time).clamp(0.0, 1.0);
                let span = self.memory.begins[course] + index;
                jobs.push(Job { span, numbers: [share; POINTS], answer: [0.0; POINTS] });
            }
        }
        self.memory.jobs = jobs;
        self.work(Question::Pressures);
        for pair in self.memory.jobs.chunks_exact(2) {
            let course = self.memory.spans[pair[0].span].course as usize;
            let sign = if self.courses[course].plan.expands { -1.0 } else { 1.0 };
            if let Some(first) = &mut firsts[course]
                && sign * pair[0].answer[0] > sign * pair[1].answer[0]
            {
                *first -= 1.0;
            }
        }
        firsts
    }

    /// Samples up to and at the begin of the spans: before it a late record shows the gas before the test.
    fn samples_before(&self, course: usize, first: f64) -> Option<Part> {
        let span = self.spans_of(course).first()?;
        let begin = self.record_time(span, 0.0);
        let samples = Samples { first, count: samples::after(begin) - first };
        let [_, drift] = self.before(&self.courses[course]);
        let at_begin = span.step.shown[0][PRESSURE];
        let pressure = samples.nodes().numbers.map(|number| at_begin + drift * (number / SAMPLE_RATE_HZ - begin));
        (samples.count > 0.0).then_some(Part { samples, pressure })
    }

    /// Step 1 of the paper on the samples of each record from its peak on: Pf, ΔP, τ, from guesses of τ.
    pub fn regressions(&mut self, answers: &[Option<Answer>], guess: impl Fn(usize) -> f64) -> Vec<Option<[f64; 3]>> {
        let firsts = self.first_samples(answers);
        self.memory.jobs.clear();
        // Per job: the samples its span holds.
        let mut held: Vec<Samples> = Vec::new();
        let mut befores = vec![None; answers.len()];
        for course in 0..answers.len() {
            let Some(first) = firsts[course] else { continue };
            let before = self.samples_before(course, first);
            befores[course] = before;
            let mut first = before.map_or(first, |part| first + part.samples.count);
            let end = samples::after(self.courses[course].plan.duration);
            for index in self.memory.begins[course]..self.memory.begins[course + 1] {
                let span = &self.memory.spans[index];
                let next = samples::after(self.record_time(span, 1.0)).min(end);
                let samples = Samples { first, count: next - first };
                if samples.count > 0.0 {
                    let numbers = samples.nodes().numbers.map(|number| self.share(span, number / SAMPLE_RATE_HZ));
                    self.memory.jobs.push(Job { span: index, numbers, answer: [0.0; POINTS] });
                    held.push(samples);
                    first = next;
                }
            }
        }
        self.work(Question::Pressures);
        let mut out = vec![None; answers.len()];
        let Memory { spans, jobs, records, .. } = &mut *self.memory;
        let mut jobs = jobs.iter().zip(held).peekable();
        for base in (0..answers.len()).step_by(WIDTH) {
            records.clear();
            let group = base..answers.len().min(base + WIDTH);
            for course in group.clone() {
                if let Some(part) = befores[course] {
                    records.add(course - base, part);
                }
                while let Some((job, samples)) = jobs.next_if(|(job, _)| spans[job.span].course as usize == course) {
                    records.add(course - base, Part { samples, pressure: job.answer });
                }
            }
            let last = group.end - 1;
            let found = records.fit(self.arch, Lanes::from_fn(|lane| guess((base + lane).min(last))));
            for course in group {
                out[course] = firsts[course].and(found.lane(course - base));
            }
        }
        out
    }
}
