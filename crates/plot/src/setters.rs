//! Setters of figures that are built by calls.

/// Writes methods that change the figure and give it back: name, arguments, and what becomes of the figure.
macro_rules! setters {
    ($($(#[$doc:meta])* $name:ident($($argument:ident: $type:ty),*) |$figure:ident| $change:expr;)*) => {
        $(
            $(#[$doc])*
            #[must_use]
            pub fn $name(mut self, $($argument: $type),*) -> Self {
                let $figure = &mut self;
                $change;
                self
            }
        )*
    };
}

pub(crate) use setters;
