//! Names the functions that an instruction comes from, by the debug information: a function that
//! was inlined keeps its name there.

use virtual_crazyflie::image::{Image, SourceMap};

use crate::Result;

/// The debug information.
pub(crate) struct Inlining<'a>(SourceMap<'a>);

impl<'a> Inlining<'a> {
    pub(crate) fn of(image: &'a Image) -> Result<Self> {
        let map = image.source_map();
        if map.is_empty() { Err("it has no debug information".into()) } else { Ok(Self(map)) }
    }

    /// Whether the instruction at `address` comes from one place of the source. It does not where
    /// the compiler has merged several equal calls into one.
    pub(crate) fn is_exact(&self, address: u32) -> bool {
        let frames = self.0.frames(address);
        let source = frames.first().and_then(|innermost| innermost.source.as_ref());
        source.is_some_and(|source| source.line > 0)
    }

    /// The functions at `address`, the innermost first. The last is the one that was compiled, and
    /// is called `whole`; it is the only one where the debug information has no name.
    pub(crate) fn chain(&self, address: u32, whole: &str) -> Vec<String> {
        let frames = self.0.frames(address);
        let mut chain: Vec<String> = frames.into_iter().filter_map(|f| f.function).collect();
        if chain.last().is_none_or(|last| last != whole) {
            chain.push(whole.to_owned());
        }
        chain
    }
}

/// The crate that a function's name begins with: of `<&agent::Agent as Debug>::fmt`, `agent`.
pub(crate) fn root(name: &str) -> &str {
    let mut words =
        name.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty());
    words.find(|word| !matches!(*word, "mut" | "const" | "dyn" | "impl")).unwrap_or_default()
}

/// Whether the function is the standard library's, which panics on behalf of its caller.
pub(crate) fn is_core(name: &str) -> bool {
    const ROOTS: [&str; 23] = [
        "core",
        "alloc",
        "std",
        "str",
        "bool",
        "char",
        "u8",
        "u16",
        "u32",
        "u64",
        "u128",
        "usize",
        "i8",
        "i16",
        "i32",
        "i64",
        "i128",
        "isize",
        "f32",
        "f64",
        "T",
        "__rustc",
        "compiler_builtins",
    ];
    ROOTS.contains(&root(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crate_is_told_from_what_surrounds_it() {
        for (name, crate_name) in [
            ("agent::Agent::step", "agent"),
            ("<agent::Agent>::step", "agent"),
            ("<&mut chain::report::Report as core::fmt::Debug>::fmt", "chain"),
            ("<dyn core::fmt::Write>::write_str", "core"),
            ("<[u8]>::copy_from_slice", "u8"),
            ("__aeabi_memcpy", "__aeabi_memcpy"),
        ] {
            assert_eq!(root(name), crate_name, "{name}");
        }
        assert!(is_core("<str>::floor_char_boundary"));
        assert!(!is_core("embassy_stm32::init"));
    }
}
