//! Lists that are objects by name in JSON, in their own order.

use serde::Serializer;

use super::{RefittedParameter, Value};

pub(super) fn by_name<S: Serializer>(values: &[(String, Value)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(values.iter().map(|(name, value)| (name, value)))
}

pub(super) fn parameters<S: Serializer>(values: &[RefittedParameter], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(values.iter().map(|p| (&p.name, p)))
}
