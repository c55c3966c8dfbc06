//! Clears the part of the core-coupled memory that outlives no reset: the start-up code knows the RAM
//! alone.

/// Fills the statics of the section `.ccm` with zeros. It is called once, before any of them is used.
#[expect(unsafe_code, reason = "the section's ends are known to the linker alone")]
pub(crate) fn clear() {
    unsafe extern "C" {
        static mut _ccm_start: u8;
        static mut _ccm_end: u8;
    }
    let (start, end) = (&raw mut _ccm_start, &raw mut _ccm_end);
    // SAFETY: memory.x places both ends around statics which nothing has used yet, in memory that is
    // the section's alone.
    unsafe { start.write_bytes(0, end.addr() - start.addr()) }
}
