//! Tiles: squares of 3 by 3 cells, the places of which robots tell each other.
//!
//! With the thesis' 0.1 m cells of this simulator a tile has its 0.3 m between two frontiers (table
//! 3.1), and it fits the air in 20 bits.

use grid_map::{Area, Cell, Frame};
use units::Point2;

/// The cells of a tile's side.
pub(crate) const SIDE: u16 = 3;

/// A square of 3 by 3 cells of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tile {
    row: u16,
    column: u16,
}

impl Tile {
    /// The number of tiles of a row or column that can be told apart on the air.
    pub const MOST: u16 = 1024;

    /// The tile in the south-western corner.
    pub(crate) const FIRST: Self = Self { row: 0, column: 0 };

    /// The tile of that column and row; `None` where one of them is not below [`MOST`](Self::MOST).
    #[must_use]
    pub const fn new(column: u16, row: u16) -> Option<Self> {
        if column < Self::MOST && row < Self::MOST { Some(Self { row, column }) } else { None }
    }

    /// The tile in which a cell lies; `None` beyond the tiles that can be told apart.
    #[must_use]
    pub const fn of(cell: Cell) -> Option<Self> {
        Self::new(cell.column / SIDE, cell.row / SIDE)
    }

    /// The column, counted from the west.
    #[must_use]
    pub const fn column(self) -> u16 {
        self.column
    }

    /// The row, counted from the south.
    #[must_use]
    pub const fn row(self) -> u16 {
        self.row
    }

    /// The cell in the tile's middle, which may lie outside a grid that the tile straddles.
    #[must_use]
    pub const fn middle(self) -> Cell {
        Cell::new(self.column * SIDE + 1, self.row * SIDE + 1)
    }

    /// The tile's middle on the floor plan.
    #[must_use]
    pub fn centre(self, frame: &Frame) -> Point2 {
        frame.centre(self.middle())
    }

    /// The cells of the tile that lie in the grid.
    pub fn cells(self, frame: &Frame) -> impl Iterator<Item = Cell> + use<> {
        let (frame, first) = (*frame, Cell::new(self.column * SIDE, self.row * SIDE));
        (0..SIDE)
            .flat_map(move |row| {
                (0..SIDE).map(move |column| Cell::new(first.column + column, first.row + row))
            })
            .filter(move |&cell| frame.contains(cell))
    }

    /// All tiles of a grid, row by row from the south.
    pub fn all(frame: &Frame) -> impl Iterator<Item = Self> + use<> {
        Self::in_area(Area::whole(frame))
    }

    /// The tiles of which a cell lies in an area, row by row from the south.
    pub(crate) fn in_area(area: Area) -> impl Iterator<Item = Self> + use<> {
        let [rows, columns] = [area.rows(), area.columns()]
            .map(|cells| cells.start() / SIDE..=(cells.end() / SIDE).min(Self::MOST - 1));
        rows.flat_map(move |row| columns.clone().map(move |column| Self { row, column }))
    }

    /// Splits the tiles of an area after as many rows of them as `most` tiles fill, but one at least:
    /// the number of tiles in those rows, and the rest of the area.
    pub(crate) fn split(area: Area, most: usize) -> (usize, Option<Area>) {
        let [rows, columns] =
            [area.rows(), area.columns()].map(|cells| (cells.start() / SIDE, cells.end() / SIDE));
        let wide = usize::from(columns.1 - columns.0) + 1;
        let high = usize::from(rows.1 - rows.0) + 1;
        let taken = (most / wide).clamp(1, high);
        let next = (usize::from(rows.0) + taken) * usize::from(SIDE);
        (taken * wide, u16::try_from(next).ok().and_then(|row| area.from_row(row)))
    }

    /// The tile's number, row by row from the south.
    pub(crate) fn number(self, frame: &Frame) -> usize {
        usize::from(self.row) * usize::from(frame.columns().div_ceil(SIDE))
            + usize::from(self.column)
    }

    /// The larger of the two differences of columns and of rows.
    #[must_use]
    pub fn steps_to(self, other: Self) -> u16 {
        self.column.abs_diff(other.column).max(self.row.abs_diff(other.row))
    }
}

/// What a robot says of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// The robot takes back what it said before.
    Gone,
    /// The robot knows what lies beyond the tile, or has looked and could not see it.
    Settled,
    /// The robot's map has an obstacle there.
    Wall,
    /// The robot has not found a way to the tile.
    Unreachable,
    /// The tile is a frontier of the robot's map.
    Frontier(Gain),
}

impl Mark {
    const FIRST_GAIN: u8 = 4;

    /// The mark's number on the air, 0 to 15.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Gone => 0,
            Self::Settled => 1,
            Self::Wall => 2,
            Self::Unreachable => 3,
            Self::Frontier(Gain(class)) => Self::FIRST_GAIN + class,
        }
    }

    /// The mark of that number; `None` above 15.
    #[must_use]
    pub const fn of_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Gone),
            1 => Some(Self::Settled),
            2 => Some(Self::Wall),
            3 => Some(Self::Unreachable),
            Self::FIRST_GAIN..=15 => Some(Self::Frontier(Gain(code - Self::FIRST_GAIN))),
            _ => None,
        }
    }
}

/// A frontier's gain, in twelve classes of four cells each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Gain(u8);

impl Gain {
    const LAST: u8 = 11;
    const WIDTH: u8 = 4;

    /// The class of so many unknown cells around a frontier, at most [`grid_map::MOST_GAIN`].
    #[must_use]
    pub const fn of_cells(cells: u8) -> Self {
        let class = cells.saturating_sub(1) / Self::WIDTH;
        Self(if class < Self::LAST { class } else { Self::LAST })
    }

    /// The middle of the class, in cells.
    #[must_use]
    pub fn cells(self) -> f32 {
        f32::from(self.0 * Self::WIDTH) + 2.5
    }

    /// By how many classes two gains differ.
    #[must_use]
    pub const fn classes_to(self, other: Self) -> u8 {
        self.0.abs_diff(other.0)
    }
}
