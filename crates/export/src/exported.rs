//! A model as source files.

use serde::Serialize;

use crate::equations::ExportedFunction;
use crate::note::ExportNote;
use crate::options::Target;

/// A file of source code.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SourceFile {
    /// Its name, without a folder.
    pub name: String,
    /// What stands in it.
    pub text: String,
}

/// An entry of x, u, or y.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// Its name in the model; of a derivative of an input such as `der(u)`.
    pub name: String,
    /// Smallest value, of an input with a range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Largest value, of an input with a range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// A parameter with its value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Constant {
    /// Its name in the model.
    pub name: String,
    /// Value in the model.
    pub value: f64,
    /// Unit, as free text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Description.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub about: Option<String>,
}

/// A model as source code: its files, and what they hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Export {
    /// Name of the model.
    pub model: String,
    /// The language.
    #[serde(rename = "language")]
    pub target: Target,
    /// What the module is called, and with which functions begin in C.
    pub name: String,
    /// The entries of x.
    pub states: Vec<Quantity>,
    /// The entries of u: inputs, then the derivatives of inputs that the equations use.
    pub inputs: Vec<Quantity>,
    /// The entries of y.
    pub outputs: Vec<Quantity>,
    /// The entries of p: the parameters that are arguments.
    pub parameters: Vec<Constant>,
    /// The parameters that are constants.
    pub constants: Vec<Constant>,
    /// The functions.
    pub functions: Vec<ExportedFunction>,
    /// What a reader has to know; all of it stands in the files, too.
    pub notes: Vec<ExportNote>,
    /// The files.
    pub files: Vec<SourceFile>,
    /// Everything as one file.
    #[serde(skip)]
    pub single: String,
}
