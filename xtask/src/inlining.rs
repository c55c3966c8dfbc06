//! Which functions an instruction comes from, by the debug information: what the compiler inlined
//! keeps its name.

use std::path::Path;

use crate::Result;
use crate::elf::demangled;

/// The debug information.
pub(crate) struct Inlining(addr2line::Loader);

impl Inlining {
    pub(crate) fn of(elf: &Path) -> Result<Self> {
        let loader = addr2line::Loader::new(elf);
        Ok(Self(loader.map_err(|why| format!("{}: debug information: {why}", elf.display()))?))
    }

    /// Whether the instruction at `address` comes from one place of the source. Where the compiler
    /// has made one of several equal calls, it does not.
    pub(crate) fn is_exact(&self, address: u32) -> bool {
        let location = self.0.find_location(u64::from(address)).ok().flatten();
        location.and_then(|location| location.line).is_some_and(|line| line > 0)
    }

    /// The functions at `address`, the innermost first, the one that was compiled last; it is
    /// `whole`, which is all there is where nothing is known.
    pub(crate) fn chain(&self, address: u32, whole: &str) -> Vec<String> {
        let mut chain = vec![];
        if let Ok(mut frames) = self.0.find_frames(u64::from(address)) {
            while let Ok(Some(frame)) = frames.next() {
                if let Some(name) = frame.function.as_ref().and_then(|name| name.raw_name().ok()) {
                    chain.push(demangled(&name));
                }
            }
        }
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
