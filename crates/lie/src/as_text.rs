//! Types that are written into JSON as their text.

/// Serializes types as what they display.
macro_rules! serialized_as_text {
    ($($type:ty),*) => {
        $(impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        })*
    };
}

pub(crate) use serialized_as_text;
