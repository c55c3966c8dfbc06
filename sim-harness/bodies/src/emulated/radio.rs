//! Reads the firmware of the radio chip: an ELF, an Intel hex file, a plain image, or an archive of the
//! vendor's releases with the image in it.

mod archive;

use std::path::Path;

use input::InputError;
use nrf51_chip::image::Program;
use virtual_crazyflie::board::RadioFirmware;

/// The source of the file.
const REMEDY: &str =
    "give crazyflie2-nrf-firmware, built with BLE=0, with --radio-elf, or leave that out";

/// Reads a firmware of the radio chip, and starts it.
///
/// # Errors
/// When the file cannot be read, or does not come to let the flight processor run.
pub fn open_radio(path: &Path) -> Result<RadioFirmware, InputError> {
    let refused = |why: String| InputError::new(why, REMEDY).in_file(path);
    let file = input::file::read(path, input::file::LARGEST_ELF)
        .map_err(|why| refused(format!("cannot be read: {why}")))?;
    let image = if archive::is_one(&file) {
        archive::radio_image(&file).map_err(|why| refused(why.to_string()))?
    } else {
        file
    };
    let program = Program::of(&image).map_err(|why| refused(why.to_string()))?;
    RadioFirmware::start(program).map_err(|why| refused(why.to_string()))
}
