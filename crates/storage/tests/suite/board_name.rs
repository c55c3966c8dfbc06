//! The board's name in the one-time programmable bytes, as the vendor's firmware reads it.

use storage::board_name::{Board, LENGTH};

/// Bytes whose blocks from the first on hold these; the others were never written.
fn bytes(blocks: &[&[u8]]) -> [u8; LENGTH] {
    let mut bytes = [0xFF; LENGTH];
    for (place, block) in bytes.chunks_mut(32).zip(blocks) {
        place.fill(0);
        place[..block.len()].copy_from_slice(block);
    }
    bytes
}

#[test]
fn the_first_block_that_is_not_struck_out_names_the_board() {
    let cases: [(&[&[u8]], Board); 13] = [
        (&[b"0;CF21"], Board::Crazyflie21),
        (&[b"0;CF21;R=D"], Board::Crazyflie21),
        (&[b"", b"", b"0;CF21;R=D"], Board::Crazyflie21),
        (&[b"0;CF20"], Board::Crazyflie20),
        (&[], Board::Crazyflie20),
        (&[b""], Board::Crazyflie20),
        (&[b"0;CB10"], Board::Other),
        (&[b"0;CB11;R=A"], Board::Other),
        (&[b"0;C21B"], Board::Other),
        (&[b"0;CF211"], Board::Other),
        (&[b"1;CF21"], Board::Other),
        (&[b"0"], Board::Other),
        (&[b"0;CB10", b"0;CF21"], Board::Other),
    ];
    for (blocks, board) in cases {
        assert_eq!(Board::named(&bytes(blocks)), board, "{blocks:?}");
    }
    assert_eq!(Board::named(&[0; LENGTH]), Board::Crazyflie20, "all blocks are struck out");
    assert_eq!(Board::named(&[b'0'; LENGTH]), Board::Other, "a text without an end");
}
