//! The file that `cargo fw` makes, where there is one.

use std::path::PathBuf;

/// Its bytes: of the file that `UCHAIN_ELF` names, or of what was built last. `None`, said aloud,
/// where there is none; with `UCHAIN_REQUIRE_ELF=1` that is a failure.
pub(crate) fn firmware_elf() -> Option<Vec<u8>> {
    let built = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join("../thumbv7em-none-eabihf/firmware/uchain-firmware");
    let path = std::env::var_os("UCHAIN_ELF").map_or(built, PathBuf::from);
    let required = std::env::var_os("UCHAIN_REQUIRE_ELF").is_some_and(|is| is == "1");
    match std::fs::read(&path) {
        Ok(bytes) => Some(bytes),
        Err(why) if required => panic!("{}: {why}; `cargo fw` makes it", path.display()),
        Err(why) => {
            println!("skipped: {}: {why}; `cargo fw` makes it", path.display());
            None
        }
    }
}
