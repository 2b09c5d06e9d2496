//! Models that state their dynamics implicitly: the table `[algebraic]`, g(x, z, u) = 0, and the key `mass`, M(x) x' = f(x, u).
//! They are solved symbolically where they are linear in the unknowns, and are ordinary models from then on.

use std::ops::Range;

use bracketry_files::{Document, FileError, Table, Value};
use bracketry_symbolic::{Expr, Pool, Symbol, closest_name};
use rustc_hash::FxHashMap;

use crate::constants::Constants;
use crate::linear_solution::solve;
use crate::rules::Declared;
use crate::scope::Scope;
use crate::system::{Algebraic, Eliminated, System};

type Located<'a, 'i> = &'a toml::Spanned<Value<'i>>;

/// An algebraic variable, and where its equation stands.
pub(crate) struct Equation {
    variable: Algebraic,
    place: Range<usize>,
}

impl Equation {
    pub(crate) fn residual(&self) -> Expr {
        self.variable.residual
    }
}

/// Declares the algebraic variables.
pub(crate) fn algebraic_names(
    doc: &Document,
    table: &Table<'_>,
    pool: &mut Pool,
    declared: &mut Declared,
) -> Result<Vec<Symbol>, FileError> {
    let mut symbols = Vec::new();
    for key in doc.sub_table(table, "algebraic")?.into_iter().flat_map(Table::keys) {
        declared.add(key.get_ref(), "algebraic variable").map_err(|e| e.at(doc, key.span()))?;
        symbols.push(pool.symbol(key.get_ref()));
    }
    Ok(symbols)
}

/// Reads the equations of the algebraic variables, one each: a residual, or `{ equation, guess }`.
pub(crate) fn algebraic_equations(
    doc: &Document,
    table: &Table<'_>,
    symbols: Vec<Symbol>,
    pool: &mut Pool,
    scope: &mut Scope<'_>,
) -> Result<Vec<Equation>, FileError> {
    let entries = doc.sub_table(table, "algebraic")?.into_iter().flatten();
    let mut equations = Vec::new();
    for ((key, value), symbol) in entries.zip(symbols) {
        let name: &str = key.get_ref();
        let mut guess = pool.int(0);
        let mut equation = value;
        if let Value::Table(given) = value.get_ref() {
            doc.only_keys(given, &["equation", "guess"], "an algebraic variable")?;
            let Some(found) = given.get("equation") else {
                let remedy = format!("write {name} = {{ equation = \"…\", guess = 0 }}: an expression that is zero");
                return Err(doc.error(key.span(), format!("`{name}` has no equation"), remedy));
            };
            equation = found;
            if let Some(v) = given.get("guess") {
                guess = doc.expression(v, "guess", pool, &mut Constants)?;
            }
        }
        let residual = doc.expression(equation, name, pool, scope)?;
        equations.push(Equation { variable: Algebraic { symbol, residual, guess }, place: equation.span() });
    }
    Ok(equations)
}

/// Solves the equations for the algebraic variables and puts their values everywhere. What cannot be solved stays in
/// [`System::algebraic`] where that is accepted.
pub(crate) fn eliminate_algebraic(
    doc: &Document,
    equations: &[Equation],
    accepted: bool,
    plain: &mut FxHashMap<String, Expr>,
    system: &mut System,
) -> Result<(), FileError> {
    if equations.is_empty() {
        return Ok(());
    }
    let residuals: Vec<Expr> = equations.iter().map(|e| e.variable.residual).collect();
    let unknowns: Vec<Symbol> = equations.iter().map(|e| e.variable.symbol).collect();
    let parameters: Vec<Symbol> = system.parameters.iter().map(|p| p.symbol).collect();
    let solution = solve(&mut system.pool, &residuals, &unknowns, &parameters).map_err(|singular| {
        let message = "the algebraic equations do not determine the algebraic variables: ∂g/∂z is singular everywhere \
                       (index above 1), as this equation shows";
        let remedy =
            "differentiate the equation with respect to time until an algebraic variable appears, and replace it by \
             the result";
        doc.error(equations[singular.equation].place.clone(), message, remedy)
    })?;
    if let Some(&(open, _)) = solution.open.first().filter(|_| !accepted) {
        let names: Vec<String> = solution.unknowns.iter().map(|&s| format!("`{}`", system.pool.name(s))).collect();
        let message = format!(
            "the equation is not linear in the algebraic variables, so {} cannot be eliminated",
            names.join(", ")
        );
        let remedy = "write the variable in [definitions] if it has a closed form; only `simulate` and `control` \
                      solve such equations numerically";
        return Err(doc.error(equations[open].place.clone(), message, remedy));
    }
    let map: FxHashMap<Expr, Expr> = solution.found.iter().map(|&(s, e)| (system.pool.sym(s), e)).collect();
    let pool = &mut system.pool;
    let everywhere = system.dynamics.iter_mut().chain(system.outputs.iter_mut().map(|o| &mut o.1));
    let everywhere = everywhere.chain(system.definitions.iter_mut().map(|d| &mut d.1)).chain(plain.values_mut());
    everywhere.for_each(|e| *e = pool.substitute(*e, &map));
    for &symbol in &unknowns {
        if let Some(&(_, value)) = solution.found.iter().find(|f| f.0 == symbol) {
            let name = pool.name(symbol).to_owned();
            system.definitions.push((name.clone(), value));
            system.eliminated.push(Eliminated::Variable { name });
        }
    }
    // The equations that are left determine the variables that are left together; the order does not matter.
    for (&symbol, &(_, residual)) in solution.unknowns.iter().zip(&solution.open) {
        let guess = equations.iter().find(|e| e.variable.symbol == symbol).map(|e| e.variable.guess);
        let guess = guess.unwrap_or_else(|| pool.int(0));
        system.algebraic.push(Algebraic { symbol, residual, guess });
    }
    Ok(())
}

/// Refuses what does not go together with algebraic variables that cannot be eliminated.
pub(crate) fn smooth_beside_algebraic(doc: &Document, table: &Table<'_>, system: &System) -> Result<(), FileError> {
    let place = |key: &str| table.get(key).map_or(0..0, toml::Spanned::span);
    let remedy = "solve the algebraic equations for their variables, and write these in [definitions]";
    let with = |what: &str| {
        format!("{what} cannot be combined with algebraic equations that are not linear in their variables")
    };
    if system.period.is_some() {
        return Err(doc.error(place("algebraic"), with("discrete time"), remedy));
    }
    if table.contains_key("delays") {
        return Err(doc.error(place("delays"), with("delays of inputs"), remedy));
    }
    if !system.input_derivatives.is_empty() {
        return Err(doc.error(place("algebraic"), with("derivatives of inputs"), remedy));
    }
    if !system.with_algebraic_states().is_smooth() {
        return Err(doc.error(place("algebraic"), with("`sign`, `abs`, `min`, `max`, and `unit`"), remedy));
    }
    Ok(())
}

/// The mass matrix of some states: M x' = f in their rows.
pub(crate) struct MassMatrix {
    /// Indices of the states.
    states: Vec<usize>,
    rows: Vec<Vec<Expr>>,
    /// Where each row stands.
    places: Vec<Range<usize>>,
}

impl MassMatrix {
    pub(crate) fn entries(&self) -> impl Iterator<Item = Expr> {
        self.rows.iter().flatten().copied()
    }

    /// Reads the key `mass`: a matrix over all states, or `{ states, matrix }`.
    pub(crate) fn read(
        doc: &Document,
        table: &Table<'_>,
        states: &[Symbol],
        pool: &mut Pool,
        scope: &mut Scope<'_>,
    ) -> Result<Option<MassMatrix>, FileError> {
        let Some(value) = table.get("mass") else { return Ok(None) };
        let (of, matrix) = match value.get_ref() {
            Value::Table(entries) => {
                doc.only_keys(entries, &["states", "matrix"], "a mass matrix")?;
                let remedy = "write mass = { states = [\"v\", \"w\"], matrix = [[\"m\", 0], [0, \"J\"]] }";
                let (Some(of), Some(matrix)) = (entries.get("states"), entries.get("matrix")) else {
                    return Err(doc.error(value.span(), "the mass matrix lacks `states` or `matrix`", remedy));
                };
                (state_list(doc, of, states, pool)?, matrix)
            }
            _ => ((0..states.len()).collect(), value),
        };
        let n = of.len();
        let remedy = format!(
            "write {n} rows of {n} entries each, one per state, or name the states: mass = {{ states = [\"v\", \"w\"], matrix = \
             [[\"m\", 0], [0, \"J\"]] }}"
        );
        let Some(list) = array(matrix).filter(|list| list.len() == n) else {
            return Err(doc.error(matrix.span(), format!("the mass matrix must be a list of {n} rows"), remedy));
        };
        let (mut rows, mut places) = (Vec::new(), Vec::new());
        for row in list {
            let Some(entries) = array(row).filter(|entries| entries.len() == n) else {
                return Err(doc.error(
                    row.span(),
                    format!("this row of the mass matrix must have {n} entries"),
                    remedy,
                ));
            };
            let read = entries.iter().map(|v| doc.expression(v, "mass", pool, scope));
            rows.push(read.collect::<Result<Vec<Expr>, FileError>>()?);
            places.push(row.span());
        }
        Ok(Some(MassMatrix { states: of, rows, places }))
    }

    /// Solves M x' = f for the derivatives and puts them into the dynamics.
    pub(crate) fn solve(self, doc: &Document, system: &mut System) -> Result<(), FileError> {
        let names: Vec<String> = self.states.iter().map(|&i| system.pool.name(system.states[i]).to_owned()).collect();
        let rates: Vec<Symbol> = names.iter().map(|name| system.pool.symbol(&format!("rate#{name}"))).collect();
        let mut equations = Vec::new();
        for (row, &state) in self.rows.iter().zip(&self.states) {
            let mut terms = Vec::new();
            for (&entry, &rate) in row.iter().zip(&rates) {
                let rate = system.pool.sym(rate);
                terms.push(system.pool.mul(entry, rate));
            }
            let sum = system.pool.sum(terms);
            equations.push(system.pool.sub(sum, system.dynamics[state]));
        }
        let parameters: Vec<Symbol> = system.parameters.iter().map(|p| p.symbol).collect();
        let solution = solve(&mut system.pool, &equations, &rates, &parameters).map_err(|singular| {
            let message = "the mass matrix is singular everywhere: this row depends on those before it, or is zero";
            let remedy = "write variables without a derivative in [algebraic], with their equations";
            doc.error(self.places[singular.equation].clone(), message, remedy)
        })?;
        if let Some(&(open, _)) = solution.open.first() {
            let message = format!(
                "the mass matrix couples {} states, too many to be inverted symbolically",
                solution.unknowns.len()
            );
            let remedy = "choose coordinates in which it has blocks of at most 6 states, or write the equations solved for the derivatives";
            return Err(doc.error(self.places[open].clone(), message, remedy));
        }
        for (&state, rate) in self.states.iter().zip(&rates) {
            if let Some(&(_, value)) = solution.found.iter().find(|f| f.0 == *rate) {
                system.dynamics[state] = value;
            }
        }
        system.eliminated.push(Eliminated::MassMatrix { states: names });
        Ok(())
    }
}

fn array<'a, 'i>(v: Located<'a, 'i>) -> Option<&'a [toml::Spanned<Value<'i>>]> {
    if let Value::Array(list) = v.get_ref() { Some(list) } else { None }
}

/// Indices of the states that a list names, each once.
fn state_list(doc: &Document, v: Located<'_, '_>, states: &[Symbol], pool: &Pool) -> Result<Vec<usize>, FileError> {
    let remedy = "write states = [\"v\", \"w\"]: names of states";
    let Some(list) = array(v) else { return Err(doc.error(v.span(), "`states` must be a list of names", remedy)) };
    let mut found: Vec<usize> = Vec::new();
    for item in list {
        let Value::String(name) = item.get_ref() else {
            return Err(doc.error(item.span(), "`states` must hold names in quotes", remedy));
        };
        let known: Vec<&str> = states.iter().map(|&s| pool.name(s)).collect();
        match known.iter().position(|k| k == name) {
            Some(i) if !found.contains(&i) => found.push(i),
            Some(_) => return Err(doc.error(item.span(), format!("`{name}` is named twice"), "name each state once")),
            None => {
                let remedy = match closest_name(name, known.iter().copied()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("the states are {}", known.join(", ")),
                };
                return Err(doc.error(item.span(), format!("`{name}` is not a state"), remedy));
            }
        }
    }
    Ok(found)
}
