//! Lists of fixed size, filled without a panic: those of `heapless` panic where an iterator has more
//! than there is room for, or a place is beyond the end.

use heapless::Vec;

/// As many of the items as there is room for.
pub(crate) fn filled<T, const N: usize>(items: impl IntoIterator<Item = T>) -> Vec<T, N> {
    let mut list = Vec::new();
    for item in items {
        if list.push(item).is_err() {
            break;
        }
    }
    list
}

/// Puts a value at a place of a list, before those that are there; says whether there was room.
pub(crate) fn insert<T, const N: usize>(list: &mut Vec<T, N>, at: usize, value: T) -> bool {
    let mut last = list.len();
    if list.push(value).is_err() {
        return false;
    }
    while last > at
        && let Some([before, after]) = list.get_mut(last - 1..last + 1)
    {
        core::mem::swap(before, after);
        last -= 1;
    }
    true
}
