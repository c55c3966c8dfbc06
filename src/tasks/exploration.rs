//! The memory of a drone that explores, in the core-coupled memory.

use agent::Exploration;
use static_cell::ConstStaticCell;

#[expect(unsafe_code, reason = "naming a section of the linker script is unsafe as such")]
// `used` keeps the compiler from believing that the memory begins with the value written here.
#[used]
// SAFETY: the section is reserved by memory.x, in memory. `ccm::clear` fills it with zeros, which are
// valid bits for all parts of the value, and of the cell, where they say that it was not taken; and the
// mission begins by setting each part.
#[unsafe(link_section = ".ccm.exploration")]
static MEMORY: ConstStaticCell<Exploration> = ConstStaticCell::new(Exploration::NEW);

/// Takes the memory, once.
pub(crate) fn take() -> Option<&'static mut Exploration> {
    MEMORY.try_take()
}
