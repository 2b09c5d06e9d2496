//! The dimension of what motion through several modes reaches, where the state itself decides the mode.

use std::fmt;

use bracketry_symbolic::{Bindings, Expr, Function, Pool, Symbol};
use serde::Serialize;

use crate::algebra::closure::Closure;
use crate::algebra::field::{Field, VectorFields};
use crate::algebra::involutive::involutive_closure;
use crate::algebra::span::{independent_rows, vanishes};
use crate::controllability::occurrence::{Edge, Occurrence, compiled};
use crate::controllability::surface::{Side, Sliding, Surface};
use crate::controllability::uninfluenced::Reach;
use crate::evidence::Evidence;
use crate::modes::ModeFields;
use crate::reason::{Reason, SwitchingReason};
use crate::undecided::Undecided;

/// Which theorem gives the dimension that is reached over all modes.
///
/// The orbit is the set of states that motions forward and backward in time reach, each mode in its own region
/// (Sussmann 1973, there for smooth fields). Whatever is reached lies in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum SwitchingTheorem {
    /// A field that is the same in both modes crosses each surface, so that the fields of all modes act together: along the
    /// flow of the common field h the other mode's field Y acts as exp(−τh) Y exp(τh), analytic in τ.
    #[serde(rename = "common crossing field")]
    CommonField,
    /// The orbit meets the surface in the orbit of the tangent fields of both modes.
    #[serde(rename = "surface closure")]
    SurfaceClosure,
    /// Switching adds nothing to what the largest mode reaches alone.
    #[serde(rename = "no gain")]
    NoGain,
    /// Only bounds are known.
    #[serde(rename = "bounds")]
    Bounds,
}

impl fmt::Display for SwitchingTheorem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SwitchingTheorem::CommonField => "common crossing field",
            SwitchingTheorem::SurfaceClosure => "surface closure",
            SwitchingTheorem::NoGain => "no gain",
            SwitchingTheorem::Bounds => "bounds",
        })
    }
}

/// The generic dimension of the orbit over all modes.
#[derive(Clone, Debug)]
pub(crate) struct Orbit {
    /// Of the strong algebra, one less than the dimension with time added.
    pub(crate) dimension: Result<usize, Reason>,
    pub(crate) theorem: SwitchingTheorem,
    /// The mode that has this dimension alone, where that of all fields together is larger.
    pub(crate) by_mode: Option<usize>,
}

/// Most pairs of modes whose surface closure is formed.
const MAX_EDGES: usize = 48;

/// The states, with time added for the strong algebra: fields (f, 1) and (g, 0).
pub(crate) struct Space<'a> {
    modes: &'a [ModeFields],
    occurrence: &'a Occurrence,
    bindings: Bindings,
    pub(crate) states: Vec<Symbol>,
    strong: bool,
}

impl<'a> Space<'a> {
    pub(crate) fn new(
        pool: &mut Pool,
        modes: &'a [ModeFields],
        occurrence: &'a Occurrence,
        strong: bool,
    ) -> Option<Space<'a>> {
        let fields = &modes.first()?.fields;
        let mut states = fields.states.clone();
        if strong {
            states.push(pool.symbol("time of the orbit"));
        }
        Some(Space { modes, occurrence, bindings: fields.bindings.clone(), states, strong })
    }

    fn with_time(&self, pool: &mut Pool, field: &Field, rate: i64) -> Field {
        let mut field = field.clone();
        if self.strong {
            field.push(pool.int(rate));
        }
        field
    }

    /// Fields that span the distribution of a mode or of modes together.
    fn spanning(&self, pool: &mut Pool, fields: &VectorFields, closure: &Closure) -> Vec<Field> {
        let mut basis: Vec<Field> = closure.basis.iter().map(|y| self.with_time(pool, y, 0)).collect();
        if self.strong {
            basis.push(self.with_time(pool, &fields.drift, 1));
        }
        basis
    }

    /// The fields (f, 1) and (g, 0) of a mode.
    fn generators(&self, pool: &mut Pool, mode: usize) -> Vec<Field> {
        let fields = &self.modes[mode].fields;
        let mut list = vec![self.with_time(pool, &fields.drift, 1)];
        for g in &fields.controls {
            list.push(self.with_time(pool, g, 0));
        }
        list
    }

    /// The surface of an edge; that of the positive mode stands for both.
    fn surface(&self, edge: &Edge) -> Expr {
        self.modes[edge.modes[0]].surfaces[edge.switch]
    }

    fn solved(&self, pool: &mut Pool, edge: &Edge) -> Option<Surface> {
        let surface = self.surface(edge);
        Surface::solve(pool, &self.states, surface, &self.bindings)
    }

    /// Whether a field crosses the surface of an edge somewhere, so at a generic point.
    fn crosses(&self, pool: &mut Pool, edge: &Edge, solved: Option<&Surface>, y: &Field) -> bool {
        if let Some(surface) = solved {
            let normal = surface.normal(pool, &self.states, y);
            return !pool.is_zero(normal) && pool.zero_test(normal, &self.bindings).is_nonzero();
        }
        let Some(at) = &edge.seen_at else { return false };
        let function = self.surface(edge);
        let along = pool.lie_derivative(function, &self.states, y);
        let states = self.modes[0].fields.states.clone();
        let Some(tape) = compiled(pool, &states, &[along], &self.bindings) else { return false };
        let mut value = [0.0];
        tape.eval(at, &mut Vec::new(), &mut value);
        value[0].abs() > CLEAR && value[0].is_finite()
    }

    /// Whether an input field that is the same in both modes crosses the surface between them.
    fn common_field(&self, pool: &mut Pool, edge: &Edge, solved: Option<&Surface>) -> bool {
        let [a, b] = edge.modes.map(|k| &self.modes[k].fields.controls);
        for (g, h) in a.iter().zip(b) {
            let mut same = true;
            for (&x, &y) in g.iter().zip(h) {
                let gap = pool.sub(x, y);
                same &= vanishes(pool, gap, &self.bindings);
            }
            let field = self.with_time(pool, g, 0);
            if same && self.crosses(pool, edge, solved, &field) {
                return true;
            }
        }
        false
    }
}

/// Values nearer to zero are not taken for nonzero.
const CLEAR: f64 = 1e-6;

/// Modes that act together, with what they span.
struct Cluster {
    members: Vec<usize>,
    basis: Vec<Field>,
}

impl Space<'_> {
    /// The dimension of the orbit; `reaches` has one entry per mode, `union` is that of the fields of all modes together.
    pub(crate) fn orbit(&self, pool: &mut Pool, reaches: &[Reach], union: &Reach, evidence: &mut Evidence) -> Orbit {
        let least = self.largest_mode(reaches);
        let of_union = if self.strong { &union.strong } else { &union.all };
        let most = match (of_union, least) {
            (Ok(union), Ok(_)) => union.dimension(),
            (Err(why), _) | (_, Err(why)) => return Orbit::open(why.clone().into()),
        };
        let Ok((mode, least)) = least else { return Orbit::open(SwitchingReason::NoMode.into()) };
        // Without inputs nothing is chosen, and all states at a time follow from the first one.
        let chosen = |m: &ModeFields| m.fields.controls.iter().flatten().any(|&e| !pool.is_zero(e));
        if self.strong && !self.modes.iter().any(chosen) {
            return Orbit { by_mode: (most > 0).then_some(mode), ..Orbit::known(0, SwitchingTheorem::NoGain) };
        }
        if least == most {
            return Orbit::known(most, SwitchingTheorem::NoGain);
        }
        match self.joined(pool, reaches, most, evidence) {
            Ok(Found::Dimension { dimension, theorem }) => {
                let by_mode = (dimension == least && dimension < most).then_some(mode);
                let theorem = if dimension == least { SwitchingTheorem::NoGain } else { theorem };
                Orbit { dimension: Ok(dimension), theorem, by_mode }
            }
            Ok(Found::AtLeast(found, why)) => {
                let least = found.max(least);
                Orbit::open(SwitchingReason::Bounds { least, most, why: Box::new(why) }.into())
            }
            Err(why) => {
                let why = Box::new(SwitchingReason::Undecided(why));
                Orbit::open(SwitchingReason::Bounds { least, most, why }.into())
            }
        }
    }

    /// The mode of largest dimension among those that are seen to occur, with that dimension.
    fn largest_mode<'r>(&self, reaches: &'r [Reach]) -> Result<(usize, usize), &'r Undecided> {
        let mut best = (0, 0);
        for (k, reach) in reaches.iter().enumerate() {
            let dimension = if self.strong { &reach.strong } else { &reach.all }.as_ref()?.dimension();
            if dimension > best.1 && self.occurrence.seen[k] {
                best = (k, dimension);
            }
        }
        Ok(best)
    }

    fn joined(
        &self,
        pool: &mut Pool,
        reaches: &[Reach],
        most: usize,
        evidence: &mut Evidence,
    ) -> Result<Found, Undecided> {
        let mut bases = Vec::new();
        for (mode, reach) in self.modes.iter().zip(reaches) {
            let closure = if self.strong { &reach.strong } else { &reach.all };
            bases.push(self.spanning(pool, &mode.fields, closure.as_ref().map_err(Clone::clone)?));
        }
        let solved: Vec<Option<Surface>> = self.occurrence.edges.iter().map(|e| self.solved(pool, e)).collect();
        let clusters = self.clusters(pool, &bases, &solved, evidence)?;
        let time = usize::from(self.strong);
        let size = |c: &Cluster| c.basis.len() - time;
        let seen = |c: &&Cluster| c.members.iter().any(|&k| self.occurrence.seen[k]);
        let mut best = clusters.iter().filter(seen).map(size).max().unwrap_or(0);
        if best == most {
            return Ok(Found::Dimension { dimension: best, theorem: SwitchingTheorem::CommonField });
        }
        let cluster = |mode: usize| clusters.iter().position(|c| c.members.contains(&mode));
        let mut between: Vec<(usize, usize, usize)> = Vec::new();
        for (k, edge) in self.occurrence.edges.iter().enumerate() {
            if let (Some(a), Some(b)) = (cluster(edge.modes[0]), cluster(edge.modes[1]))
                && a != b
            {
                between.push((k, a, b));
            }
        }
        if between.len() > MAX_EDGES {
            return Ok(Found::AtLeast(best, SwitchingReason::Pairs(between.len())));
        }
        let single = {
            let mut switches: Vec<usize> = between.iter().map(|b| self.occurrence.edges[b.0].switch).collect();
            switches.dedup();
            clusters.len() == 2 && switches.len() == 1
        };
        let (mut equal, mut gain, mut open) = (true, false, None);
        for (k, a, b) in between {
            let edge = &self.occurrence.edges[k];
            let Some(surface) = &solved[k] else {
                let function = self.surface(edge);
                open.get_or_insert(SwitchingReason::Unsolved(Function::new(pool, function)));
                continue;
            };
            let sides = [&clusters[a], &clusters[b]];
            let across = self.across(pool, edge, surface, sides, evidence)?;
            if let Some(why) = across.open {
                open.get_or_insert(why);
            }
            equal &= across.same;
            let Some(dimension) = across.dimension.map(|d| d - time).filter(|&d| d > best) else { continue };
            if edge.seen_at.is_some() {
                (best, gain) = (dimension, true);
            } else {
                open.get_or_insert_with(|| SwitchingReason::NotSeen(Function::new(pool, surface.function)));
            }
        }
        let theorem = if gain { SwitchingTheorem::SurfaceClosure } else { SwitchingTheorem::CommonField };
        if best == most || open.is_none() && (equal || single) {
            return Ok(Found::Dimension { dimension: best, theorem });
        }
        Ok(Found::AtLeast(best, open.unwrap_or(SwitchingReason::SeveralSurfaces)))
    }

    /// Modes joined by crossings at which their fields act together.
    fn clusters(
        &self,
        pool: &mut Pool,
        bases: &[Vec<Field>],
        solved: &[Option<Surface>],
        evidence: &mut Evidence,
    ) -> Result<Vec<Cluster>, Undecided> {
        let mut of: Vec<usize> = (0..self.modes.len()).collect();
        for (edge, surface) in self.occurrence.edges.iter().zip(solved) {
            let [a, b] = edge.modes;
            if let Some(limit) = pool.reached_limit() {
                return Err(limit.into());
            }
            if of[a] == of[b] || edge.seen_at.is_none() {
                continue;
            }
            let joined = self.common_field(pool, edge, surface.as_ref()) || {
                let generators = self.generators(pool, a);
                self.same_span(pool, &bases[a], &bases[b], evidence)?
                    && generators.iter().any(|y| self.crosses(pool, edge, surface.as_ref(), y))
            };
            if joined {
                let (from, to) = (of[b], of[a]);
                of.iter_mut().filter(|c| **c == from).for_each(|c| *c = to);
            }
        }
        let mut clusters = Vec::new();
        for root in 0..self.modes.len() {
            let members: Vec<usize> =
                (0..self.modes.len()).filter(|&k| of[k] == root && !self.occurrence.impossible[k]).collect();
            let basis = match members.as_slice() {
                [] => continue,
                [one] => bases[*one].clone(),
                _ => {
                    let family: Vec<VectorFields> = members.iter().map(|&k| self.modes[k].fields.clone()).collect();
                    // All have the same states.
                    let Ok(all) = VectorFields::switched(pool, &family) else { continue };
                    let closure = if self.strong {
                        all.strong_accessibility(pool, evidence)?
                    } else {
                        all.accessibility(pool, evidence)?
                    };
                    self.spanning(pool, &all, &closure)
                }
            };
            clusters.push(Cluster { members, basis });
        }
        Ok(clusters)
    }

    fn same_span(&self, pool: &mut Pool, a: &[Field], b: &[Field], evidence: &mut Evidence) -> Result<bool, Undecided> {
        if a.len() != b.len() {
            return Ok(false);
        }
        let both: Vec<Field> = a.iter().chain(b).cloned().collect();
        Ok(independent_rows(pool, &both, &self.bindings, evidence)?.len() == a.len())
    }

    /// The orbit across one surface.
    ///
    /// A function that is constant along the distribution of either side and continuous across the surface S is
    /// constant on S along the fields of both that are tangent to S. So the orbit meets S in the orbit of these within
    /// S, and has one dimension more.
    fn across(
        &self,
        pool: &mut Pool,
        edge: &Edge,
        surface: &Surface,
        sides: [&Cluster; 2],
        evidence: &mut Evidence,
    ) -> Result<Across, Undecided> {
        let generators = edge.modes.map(|k| self.generators(pool, k));
        let mut parts: Vec<Option<Vec<Field>>> = Vec::new();
        for (cluster, generators) in sides.iter().zip(&generators) {
            let side = Side { basis: &cluster.basis, generators };
            parts.push(side.tangent(pool, &self.states, surface, &self.bindings, evidence)?);
        }
        // The surface cannot be reached from either side.
        if parts.iter().all(Option::is_none) {
            return Ok(Across { dimension: None, same: true, open: None });
        }
        let inner = surface.states(&self.states);
        let tangent: Vec<Field> = parts.iter().flatten().flatten().cloned().collect();
        let closed = involutive_closure(pool, &inner, &tangent, &self.bindings, evidence)?;
        let dimension = closed.dimension() + 1;
        let crossed = parts.iter().all(Option::is_some);
        let same = crossed && sides.iter().all(|c| c.basis.len() == dimension);
        let mut more = Vec::new();
        for (part, generators) in parts.iter().zip(&generators) {
            if part.is_none() {
                let side = Side { basis: &[], generators };
                more.extend(side.within(pool, surface));
            }
        }
        let [plus, minus] = &generators;
        match Sliding::of(pool, &self.states, surface, [plus, minus], &self.bindings) {
            Sliding::None => {}
            Sliding::Fields(fields) => more.extend(fields),
            Sliding::Open => {
                let why = SwitchingReason::Sliding(Function::new(pool, surface.function));
                return Ok(Across { dimension: Some(dimension), same, open: Some(why) });
            }
        }
        let mut open = None;
        if !more.is_empty() {
            more.extend(closed.basis);
            let all = involutive_closure(pool, &inner, &more, &self.bindings, evidence)?;
            if all.dimension() + 1 > dimension {
                open = Some(SwitchingReason::Sliding(Function::new(pool, surface.function)));
            }
        }
        Ok(Across { dimension: Some(dimension), same, open })
    }
}

struct Across {
    /// Dimension of the orbit; none where the surface is not reached.
    dimension: Option<usize>,
    /// Whether both sides have it already.
    same: bool,
    open: Option<SwitchingReason>,
}

enum Found {
    Dimension { dimension: usize, theorem: SwitchingTheorem },
    AtLeast(usize, SwitchingReason),
}

impl Orbit {
    fn known(dimension: usize, theorem: SwitchingTheorem) -> Orbit {
        Orbit { dimension: Ok(dimension), theorem, by_mode: None }
    }

    fn open(why: Reason) -> Orbit {
        Orbit { dimension: Err(why), theorem: SwitchingTheorem::Bounds, by_mode: None }
    }
}
