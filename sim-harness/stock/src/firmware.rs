//! Reads the ELF of Bitcraze's firmware.

use std::path::Path;
use std::sync::Arc;

use bodies::emulated::open_radio;
use input::InputError;
use virtual_crazyflie::board::{Config, Crazyflie, RadioFirmware};
use virtual_crazyflie::cpu::Program;
use virtual_crazyflie::image::Image;
use virtual_crazyflie::machine::{self, Machine, MachineConfig};

/// Where it comes from.
const REMEDY: &str = "give crazyflie-firmware's cf2.elf with --elf: its own `make` builds it";
/// A function of the vendor's that every build of crazyflie-firmware has.
const SYMBOL: &str = "platformInit";

/// An ELF of crazyflie-firmware.
#[derive(Clone)]
pub struct StockFirmware {
    image: Arc<Image>,
    program: Program,
    radio: Option<RadioFirmware>,
}

impl StockFirmware {
    /// Reads an ELF.
    ///
    /// # Errors
    /// When the file cannot be read, could not be flashed, or is another firmware.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let refused = |why: String| InputError::new(why, REMEDY).in_file(path);
        let bytes = input::file::read(path, input::file::LARGEST_ELF)
            .map_err(|why| refused(format!("cannot be read: {why}")))?;
        let image = Image::parse(bytes).map_err(|why| refused(why.to_string()))?;
        if !Self::is_in(&image) {
            return Err(refused("is not crazyflie-firmware".into()));
        }
        let program = machine::decode(&image);
        Ok(Self { image: Arc::new(image), program, radio: None })
    }

    /// Adds the radio chip's own firmware, where a file with it is given.
    ///
    /// # Errors
    /// When the file has none that the chip runs.
    pub fn with_radio(self, path: Option<&Path>) -> Result<Self, InputError> {
        Ok(Self { radio: path.map(open_radio).transpose()?, ..self })
    }

    /// Whether a file is an ELF of crazyflie-firmware.
    #[must_use]
    pub fn is_at(path: &Path) -> bool {
        input::file::read(path, input::file::LARGEST_ELF)
            .ok()
            .and_then(|bytes| Image::parse(bytes).ok())
            .as_ref()
            .is_some_and(Self::is_in)
    }

    fn is_in(image: &Image) -> bool {
        image.find(SYMBOL).is_some()
    }

    /// The ELF.
    #[must_use]
    pub fn image(&self) -> &Arc<Image> {
        &self.image
    }

    /// A machine that runs it.
    pub(super) fn machine(&self) -> Machine<Crazyflie> {
        let board = Crazyflie::new(&Config { radio: self.radio.clone(), ..Config::default() });
        let config = MachineConfig::default();
        Machine::with_program(Arc::clone(&self.image), self.program.clone(), board, config)
    }
}
