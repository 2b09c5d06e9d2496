//! Figures of a result, drawn when they are asked for.

use bracketry::plot::{Drawing, PlotError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::Failure;

type Draw = Box<dyn Fn() -> Result<Drawing, PlotError> + Send + Sync>;

/// The figures of one result.
#[pyclass(frozen, module = "bracketry._native")]
#[derive(Default)]
pub(crate) struct Figures {
    figures: Vec<(String, Draw)>,
}

impl Figures {
    /// With one more figure.
    pub(crate) fn with(
        mut self,
        name: impl Into<String>,
        draw: impl Fn() -> Result<Drawing, PlotError> + Send + Sync + 'static,
    ) -> Self {
        self.figures.push((name.into(), Box::new(draw)));
        self
    }

    fn draw(&self, name: &str) -> Result<Drawing, Failure> {
        let Some((_, draw)) = self.figures.iter().find(|(known, _)| known == name) else {
            let known = self.names();
            let known =
                if known.is_empty() { "there are none".to_owned() } else { format!("there are {}", known.join(", ")) };
            return Err(Failure::new(format!("there is no figure `{name}`; {known}")));
        };
        Ok(draw()?)
    }
}

#[pymethods]
impl Figures {
    /// Names of the figures.
    fn names(&self) -> Vec<String> {
        self.figures.iter().map(|(name, _)| name.clone()).collect()
    }

    /// A figure as SVG text.
    fn svg(&self, py: Python<'_>, name: &str) -> PyResult<String> {
        Ok(py.detach(|| self.draw(name))?.svg().to_owned())
    }

    /// A figure as the bytes of a PNG file.
    fn png<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyBytes>> {
        let png = py.detach(|| -> Result<Vec<u8>, Failure> { Ok(self.draw(name)?.png()?) })?;
        Ok(PyBytes::new(py, &png))
    }
}
