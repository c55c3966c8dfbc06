//! The layout of a type in memory.

use std::sync::{Arc, OnceLock, Weak};

/// A type.
pub(super) struct Shape {
    pub(super) name: String,
    pub(super) size: u32,
    pub(super) kind: Kind,
}

/// What sort of type it is.
pub(super) enum Kind {
    Bool,
    Char,
    Unsigned,
    Signed,
    Float,
    Structure {
        members: Vec<Member>,
    },
    /// An enum of which a number says which variant it is.
    Choice {
        discriminant: Discriminant,
        variants: Vec<Variant>,
    },
    /// An enum of names alone.
    Names {
        names: Vec<(u64, String)>,
    },
    Array {
        element: Arc<Shape>,
        count: u32,
    },
    Pointer {
        target: Target,
    },
    /// A function, which has no value to read.
    Opaque,
}

/// What a pointer points to: types may point to each other in a circle.
#[derive(Default)]
pub(super) struct Target(OnceLock<Weak<Shape>>);

impl Target {
    pub(super) fn get(&self) -> Option<Arc<Shape>> {
        self.0.get()?.upgrade()
    }

    pub(super) fn set(&self, shape: &Arc<Shape>) {
        // The first one that is found stays: they are the same.
        let _ = self.0.set(Arc::downgrade(shape));
    }
}

/// A field.
pub(super) struct Member {
    pub(super) name: String,
    pub(super) offset: u32,
    pub(super) shape: Arc<Shape>,
}

impl Member {
    /// The compiler calls the fields of a tuple `__0`, `__1`.
    pub(super) fn is_called(&self, name: &str) -> bool {
        self.name == name || self.name.strip_prefix("__") == Some(name)
    }
}

/// Where the number is that tells the variants apart; `None` where there is but one.
pub(super) struct Discriminant(pub(super) Option<(u32, u32)>);

/// One variant of an enum.
pub(super) struct Variant {
    /// Its number; `None` for the one that all other numbers mean.
    pub(super) number: Option<u64>,
    pub(super) name: String,
    pub(super) shape: Arc<Shape>,
}
