//! A model: read, written, evaluated.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::OnceLock;

use bracketry::symbolic::{Rational, Symbol, Tape};
use bracketry::system::{Document, System};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::error::Failure;

/// Name, value, unit, smallest and largest value, description.
type ParameterRow = (String, f64, Option<String>, Option<f64>, Option<f64>, Option<String>);

/// Names with their formulas.
type Formulas = Vec<(String, String)>;

/// A model and the text it came from.
#[pyclass(frozen, module = "bracketry._native")]
pub(crate) struct Model {
    pub(crate) system: System,
    file: String,
    text: String,
    rates: OnceLock<Tape>,
    outputs: OnceLock<Tape>,
    jacobian: OnceLock<Tape>,
}

impl Model {
    pub(crate) fn new(system: System, file: String, text: String) -> Self {
        let (rates, outputs, jacobian) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Self { system, file, text, rates, outputs, jacobian }
    }

    /// A model that an analysis made.
    pub(crate) fn made(system: System) -> Result<Self, Failure> {
        let text = system.to_toml()?;
        let file = format!("{}.toml", system.name);
        Ok(Self::new(system, file, text))
    }
}

#[pymethods]
impl Model {
    /// A model from text; `file` is how errors call it, `name` what it is called unless the text names it.
    #[staticmethod]
    fn parse(py: Python<'_>, file: String, text: String, name: String) -> PyResult<Self> {
        py.detach(|| -> Result<Self, Failure> {
            let mut system = System::parse(&file, &text)?;
            if system.name == file {
                system.name = name;
            }
            Ok(Self::new(system, file, text))
        })
        .map_err(Into::into)
    }

    /// A model from a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| -> Result<Self, Failure> {
            let system = System::read(&path)?;
            let text = Document::read(&path)?.text().to_owned();
            Ok(Self::new(system, path.display().to_string(), text))
        })
        .map_err(Into::into)
    }

    /// How errors call the model.
    #[getter]
    fn file(&self) -> &str {
        &self.file
    }

    /// The text of the model as it was given.
    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    #[getter]
    fn name(&self) -> &str {
        &self.system.name
    }

    #[getter]
    fn states(&self) -> Vec<String> {
        self.system.state_names()
    }

    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.system.input_names()
    }

    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.system.outputs.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Derivatives of inputs that the equations use: input and order.
    #[getter]
    fn input_derivatives(&self) -> Vec<(String, u32)> {
        let names = self.system.input_names();
        self.system.input_derivatives.iter().map(|d| (names[d.input].clone(), d.order)).collect()
    }

    #[getter]
    fn parameters(&self) -> Vec<ParameterRow> {
        let number = |r: &Rational| r.to_f64().value();
        let row = |p: &bracketry::system::Parameter| {
            let name = self.system.symbol_name(p.symbol).to_owned();
            let (min, max) = (p.min.as_ref().map(number), p.max.as_ref().map(number));
            (name, number(&p.value), p.unit.clone(), min, max, p.about.clone())
        };
        self.system.parameters.iter().map(row).collect()
    }

    /// Values of states and inputs at the model's point, if it has one.
    #[getter]
    fn point(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        self.system.point_values()
    }

    /// The same model with other values of parameters, as decimal numbers.
    fn with_parameters(&self, values: Vec<(String, String)>) -> PyResult<Self> {
        let mut system = self.system.clone();
        for (name, text) in values {
            let value = system.pool.parse(&text).map_err(Failure::from)?;
            let value = system.pool.number(value).cloned();
            let known = value.is_some_and(|value| system.set_parameter(&name, value));
            if !known {
                let known: Vec<&str> = system.parameters.iter().map(|p| system.symbol_name(p.symbol)).collect();
                let message = format!("the model has no parameter `{name}`; it has {}", known.join(", "));
                return Err(Failure::new(message).into());
            }
        }
        // Reading it anew checks the limits of the parameters.
        let made = Self::made(system)?;
        System::parse(&made.file, &made.text).map_err(Failure::from)?;
        Ok(made)
    }

    /// The text of a model file, definitions expanded.
    fn to_toml(&self) -> PyResult<String> {
        Ok(self.system.to_toml().map_err(Failure::from)?)
    }

    /// The unit of the time.
    #[getter]
    fn time_unit(&self) -> &str {
        self.system.quantities.time_unit.symbol()
    }

    /// Units of states, inputs, and outputs, where the model states them.
    #[getter]
    fn units(&self) -> HashMap<String, String> {
        let unit = |name: String| Some((name.clone(), self.system.quantities.unit(&name)?.to_owned()));
        self.system.quantity_names().into_iter().filter_map(unit).collect()
    }

    /// What stands at the axes of the time, `t`, and of states, inputs, and outputs.
    #[getter]
    fn titles(&self) -> HashMap<String, String> {
        titles(&self.system)
    }

    /// Each state with its time derivative, as text.
    fn equations(&self) -> Vec<(String, String)> {
        let rates = self.system.dynamics.iter().map(|e| self.system.pool.text(*e));
        self.system.state_names().into_iter().zip(rates).collect()
    }

    /// Each state with its time derivative, then each output, in LaTeX.
    fn latex(&self) -> (Formulas, Formulas) {
        let mut pool = self.system.pool.clone();
        let mut symbol = |s: &Symbol| {
            let e = pool.sym(*s);
            pool.latex(e)
        };
        let states: Vec<String> = self.system.states.iter().map(&mut symbol).collect();
        let rates = self.system.dynamics.iter().map(|e| self.system.pool.latex(*e));
        let outputs = self.system.outputs.iter().map(|(name, e)| (name.clone(), self.system.pool.latex(*e)));
        (states.into_iter().zip(rates).collect(), outputs.collect())
    }

    /// Time derivatives of the states at every row of arguments: states, inputs, derivatives of inputs.
    fn rates<'py>(&self, py: Python<'py>, rows: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let tape =
            compiled(&self.rates, || Ok(self.system.compile(&self.system.arguments(), &self.system.dynamics)?))?;
        evaluate(py, tape, &rows)
    }

    /// Outputs at every row of arguments.
    fn output_values<'py>(
        &self,
        py: Python<'py>,
        rows: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let tape = compiled(&self.outputs, || {
            let outputs: Vec<_> = self.system.outputs.iter().map(|(_, e)| *e).collect();
            Ok(self.system.compile(&self.system.arguments(), &outputs)?)
        })?;
        evaluate(py, tape, &rows)
    }

    /// Derivatives of the rates by states and inputs at every row of arguments, row by row of the Jacobian.
    fn jacobian<'py>(&self, py: Python<'py>, rows: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let tape = compiled(&self.jacobian, || {
            let mut system = self.system.clone();
            let arguments = system.arguments();
            let by: Vec<Symbol> = system.states.iter().chain(&system.inputs).copied().collect();
            let rates = system.dynamics.clone();
            let entries: Vec<_> = system.pool.jacobian(&rates, &by).into_iter().flatten().collect();
            Ok(system.compile(&arguments, &entries)?)
        })?;
        evaluate(py, tape, &rows)
    }
}

/// The tape of a cell, compiled when it is first asked for.
/// What stands at the axes of the time, `t`, and of states, inputs, and outputs.
pub(crate) fn titles(system: &System) -> HashMap<String, String> {
    let title = |name: String| (name.clone(), system.quantities.title(&name));
    let time = ("t".to_owned(), system.quantities.time_title("t"));
    system.quantity_names().into_iter().map(title).chain([time]).collect()
}

fn compiled(cell: &OnceLock<Tape>, compile: impl FnOnce() -> Result<Tape, Failure>) -> Result<&Tape, Failure> {
    if let Some(tape) = cell.get() {
        return Ok(tape);
    }
    let tape = compile()?;
    Ok(cell.get_or_init(|| tape))
}

/// The results of a tape for every row, one after the other.
fn evaluate<'py>(
    py: Python<'py>,
    tape: &Tape,
    rows: &PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let array = rows.as_array();
    if array.ncols() != tape.n_inputs() {
        let message = format!("{} arguments in a row, the model has {}", array.ncols(), tape.n_inputs());
        return Err(Failure::new(message).into());
    }
    let values = py.detach(|| {
        let (mut work, mut arguments) = (Vec::new(), vec![0.0; tape.n_inputs()]);
        let width = tape.n_outputs();
        let mut values = vec![0.0; array.nrows() * width];
        for (k, row) in array.rows().into_iter().enumerate() {
            for (argument, value) in arguments.iter_mut().zip(row) {
                *argument = *value;
            }
            tape.eval(&arguments, &mut work, &mut values[k * width..(k + 1) * width]);
        }
        values
    });
    Ok(values.into_pyarray(py))
}
