//! Candidates for an affine form of a system, as values.

use std::collections::BTreeMap;

use bracketry_symbolic::{Certificate, Function, Symbol};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use crate::new_input::{AtPoint, NewInput};
use crate::new_state::NewState;
use crate::range::{Bound, Range};
use crate::range_note::RangeNote;
use crate::reason::AffineReason;
use crate::singular::SingularSet;
use crate::system::{InputRange, System};

/// How a system became affine.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// It is affine as it stands.
    None,
    /// New inputs v = w(u).
    InputChange,
    /// New inputs v = w(x, u) that depend on the state.
    Feedback,
    /// Integrators: u becomes a state and its derivative the input; perhaps with new inputs for others.
    InputAugmentation,
    /// New states z = T(x, u, …) whose derivatives need lower derivatives of the inputs.
    CoordinateChange,
}

/// A candidate for making a system affine, accepted or rejected.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What is done.
    pub method: Method,
    /// Whether [`System::affinize`] takes this one.
    pub chosen: bool,
    /// Integrators in front of each input that gets any.
    pub integrators: BTreeMap<String, u32>,
    /// States and inputs that stand for derivatives of inputs, with the place of the input in the original.
    pub(crate) derivatives: Vec<(Symbol, usize)>,
    /// States beyond those of the original.
    pub added_states: usize,
    /// New inputs, in order; inputs that stay as they are, or get integrators, need not be listed.
    pub input_change: Vec<NewInput>,
    /// Old inputs as functions of the new ones (and the states), where these were found in closed form and checked; of
    /// several solutions one.
    pub inverse: Vec<(String, Function)>,
    /// New states that replace old ones.
    pub coordinate_change: Vec<NewState>,
    /// Where the new inputs do not determine the old ones locally; `None` where that is nowhere or no short condition
    /// was found.
    pub singular_set: Option<SingularSet>,
    /// For new inputs and a model with a point: whether the Jacobian of w has full rank there.
    pub regular_at_point: Option<bool>,
    /// For new inputs and a model with a point: whether their values there are interior to the convex hull of all
    /// values that they take together; `None` where that was not established.
    ///
    /// The hull decides on local controllability: reachable sets with inputs in V are dense in those with inputs in co
    /// V, and where the brackets span, a dense reachable set near x₀ can be completed from both ends by open sets
    /// (Krener), so that the affine system is small-time locally controllable with V if it is with co V.
    pub interior_at_point: Option<bool>,
    /// For new inputs and a model with a point: whether they take, together, all values near those at the point, so that any
    /// small feedback of them can be realized; `None` where that was not established.
    pub covers_at_point: Option<bool>,
    /// Whether the new inputs take their values independently of each other; `None` where that was not established.
    pub independent_ranges: Option<bool>,
    /// Where the ranges of the candidate's inputs say less than those of the original's.
    pub range_notes: Vec<RangeNote>,
    /// The affine system; `None` for a rejected candidate.
    pub system: Option<System>,
    /// The tests that the affine system, with the new inputs and states written in the old ones, is the original;
    /// `None` where it is so term by term.
    pub certificate: Option<Certificate>,
    /// The reason for it, or for its rejection.
    pub why: AffineReason,
}

impl Candidate {
    pub(crate) fn new(method: Method, why: AffineReason) -> Self {
        Candidate {
            method,
            chosen: false,
            integrators: BTreeMap::new(),
            derivatives: Vec::new(),
            added_states: 0,
            input_change: Vec::new(),
            inverse: Vec::new(),
            coordinate_change: Vec::new(),
            singular_set: None,
            regular_at_point: None,
            interior_at_point: None,
            covers_at_point: None,
            independent_ranges: None,
            range_notes: Vec::new(),
            system: None,
            certificate: None,
            why,
        }
    }

    /// Whether it gives an affine system.
    pub fn is_accepted(&self) -> bool {
        self.system.is_some()
    }

    /// Writes the ranges of new inputs, and of inputs that stay, into the candidate's system, and notes what these do
    /// not say of the ranges of the old ones.
    pub(crate) fn transfer_ranges(&mut self, original: &System) {
        let Some(system) = self.system.as_mut().filter(|_| self.method != Method::None) else { return };
        let stays = |r: &&InputRange| system.inputs.contains(&r.input);
        let mut ranges: Vec<InputRange> = original.input_ranges.iter().filter(stays).cloned().collect();
        for v in &self.input_change {
            let Some(&input) = system.inputs.iter().find(|&&u| system.pool.name(u) == v.name) else { continue };
            if let (Range::Interval { lower, upper }, false) = (&v.values, ranges.iter().any(|r| r.input == input)) {
                let end = |b: &Option<Bound>| b.as_ref().and_then(Bound::rational);
                ranges.push(InputRange { input, min: end(lower), max: end(upper) });
            }
        }
        system.input_ranges = ranges;
        self.range_notes = RangeNote::of(original, &self.input_change, self.independent_ranges, &self.integrators);
    }
}

/// A new input with its function printed.
#[derive(Serialize)]
struct PrintedInput<'a> {
    name: &'a str,
    function: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<String>,
    values: &'a Range,
    at_point: AtPoint,
}

impl Serialize for Candidate {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut s = serializer.serialize_struct("Candidate", 15)?;
        s.serialize_field("method", &self.method)?;
        s.serialize_field("accepted", &self.is_accepted())?;
        s.serialize_field("chosen", &self.chosen)?;
        s.serialize_field("why", &self.why)?;
        let Some(system) = &self.system else { return s.end() };
        s.serialize_field("added_states", &self.added_states)?;
        s.serialize_field("integrators", &self.integrators)?;
        if !self.input_change.is_empty() {
            let printed: Vec<PrintedInput<'_>> = self
                .input_change
                .iter()
                .map(|v| PrintedInput {
                    name: &v.name,
                    function: system.pool.text(v.function),
                    range: v.range(),
                    values: &v.values,
                    at_point: v.at_point,
                })
                .collect();
            s.serialize_field("input_change", &printed)?;
            let inverse: BTreeMap<&String, String> = self.inverse.iter().map(|(u, e)| (u, e.text())).collect();
            s.serialize_field("inverse", &inverse)?;
            s.serialize_field("singular_set", &self.singular_set)?;
            s.serialize_field("independent_ranges", &self.independent_ranges)?;
        }
        if !self.range_notes.is_empty() {
            let notes: Vec<String> = self.range_notes.iter().map(ToString::to_string).collect();
            s.serialize_field("range_notes", &notes)?;
        }
        if !self.coordinate_change.is_empty() {
            s.serialize_field("coordinate_change", &self.coordinate_change)?;
        }
        if let Some(regular) = self.regular_at_point {
            s.serialize_field("regular_at_point", &regular)?;
            s.serialize_field("interior_at_point", &self.interior_at_point)?;
            s.serialize_field("covers_at_point", &self.covers_at_point)?;
        }
        s.serialize_field("states", &system.state_names())?;
        s.serialize_field("inputs", &system.input_names())?;
        // How certain it is that the inverse restores the original.
        let certificate = self.certificate.map_or_else(|| "identical".to_owned(), |c| c.to_string());
        s.serialize_field("certificate", &certificate)?;
        s.end()
    }
}
