//! The request that each channel of each stream serves (RM0090, "DMA1 request mapping" and "DMA2
//! request mapping"), as far as the requesting peripheral is modelled.

use crate::soc::context::Request;

/// The controllers, by index.
pub(super) const DMA1: usize = 0;
/// The other.
pub(super) const DMA2: usize = 1;

/// The request of a channel of a stream; none where the peripheral is not modelled, or nothing
/// there.
pub(super) const fn request(controller: usize, stream: usize, channel: u32) -> Option<Request> {
    Some(match (controller, channel, stream) {
        (DMA1, 1, 0 | 5) => Request::I2cReceive(0),
        (DMA1, 1, 6 | 7) => Request::I2cTransmit(0),
        (DMA1, 7, 2 | 3) => Request::I2cReceive(1),
        (DMA1, 7, 7) => Request::I2cTransmit(1),
        (DMA1, 3, 2) => Request::I2cReceive(2),
        (DMA1, 3, 4) => Request::I2cTransmit(2),
        (DMA2, 3, 0 | 2) => Request::Spi1Receive,
        (DMA2, 3, 3 | 5) => Request::Spi1Transmit,
        (DMA2, 5, 1 | 2) => Request::Usart6Receive,
        (DMA2, 5, 6 | 7) => Request::Usart6Transmit,
        _ => return None,
    })
}
