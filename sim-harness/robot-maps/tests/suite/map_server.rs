//! Occupancy maps: what pixels mean, what is refused, and that what is written is read back.

use cave_survey::Memory;
use png::{BitDepth, ColorType, Encoder};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use robot_maps::{Cell, Occupancy, Refusal, map_server};

const F: Cell = Cell::Free;
const O: Cell = Cell::Occupied;
const U: Cell = Cell::Unknown;

fn yaml(more: &str) -> String {
    format!(
        "image: m.pgm\nresolution: 0.05\norigin: [-1.0, 2.0, 0.0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\n{more}"
    )
}

fn read(yaml: &str, image: &[u8]) -> Result<Occupancy, Refusal> {
    map_server::read(&Memory::default().with("m.yaml", yaml).with("m.pgm", image), "m.yaml")
}

#[test]
fn pixels_mean_what_map_server_says() {
    // Black, dark grey, map_saver's unknown, light grey, white; then 100 and 101 per cent.
    let image = b"P2 # by hand\n7 1\n# white is\n255\n0 60 205 230 255 100 101";
    let cells = |more: &str| read(&yaml(more), image).unwrap().cells().to_vec();
    assert_eq!(cells("negate: 0\n"), [O, O, U, F, F, U, U]);
    assert_eq!(cells("mode: scale\n"), [O, O, U, F, F, U, U]);
    assert_eq!(cells("negate: 1\n"), [F, U, O, O, O, U, U]);
    assert_eq!(cells("negate: true\nmode: trinary\n"), [F, U, O, O, O, U, U]);
    // In per cent: 0, 60, unknown, unknown, unknown, 100, unknown.
    assert_eq!(cells("mode: raw\n"), [F, U, U, U, U, O, U]);
}

#[test]
fn the_first_row_of_the_image_is_the_uppermost() {
    let map = read(&yaml(""), b"P5 2 2 255\n\x00\xfe\xfe\xfe").unwrap();
    assert_eq!((map.cell(0, 1), map.cell(0, 0), map.cell(7, 0)), (O, F, U));
    assert_eq!(map.place(0.0, 0.0), [-1.0, 2.0]);
    let [x, y] = map.grid(map.place(1.5, 0.25));
    assert!((x - 1.5).abs() < 1e-9 && (y - 0.25).abs() < 1e-9);
}

#[test]
fn sixteen_bits_and_other_whites_are_scaled() {
    let wide = read(&yaml(""), b"P5 2 1 65535\n\x00\x00\xff\xff").unwrap();
    assert_eq!(wide.cells(), [O, F]);
    assert_eq!(read(&yaml(""), b"P5 2 1 15\n\x00\x0f").unwrap().cells(), [O, F]);
}

/// A PNG image of so many columns.
fn png(columns: u32, colour: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let samples = colour.samples() * if depth == BitDepth::Sixteen { 2 } else { 1 };
    let rows = (data.len() / samples) as u32 / columns;
    let mut encoder = Encoder::new(&mut bytes, columns, rows);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

#[test]
fn png_images_of_every_colour_and_depth_are_read() {
    let grey = [0, 205, 254];
    let wide: Vec<u8> = grey.iter().flat_map(|&it| [it, it]).collect();
    let coloured: Vec<u8> = grey.iter().flat_map(|&it| [it; 3]).collect();
    let wide_coloured: Vec<u8> = grey.iter().flat_map(|&it| [it; 6]).collect();
    let opaque: Vec<u8> = grey.iter().flat_map(|&it| [it, it, it, 255]).collect();
    for image in [
        png(3, ColorType::Grayscale, BitDepth::Eight, &grey),
        png(3, ColorType::Grayscale, BitDepth::Sixteen, &wide),
        png(3, ColorType::Rgb, BitDepth::Eight, &coloured),
        png(3, ColorType::Rgb, BitDepth::Sixteen, &wide_coloured),
        png(3, ColorType::Rgba, BitDepth::Eight, &opaque),
    ] {
        let map = read(&yaml(""), &image).unwrap();
        assert_eq!((map.cells(), map.warnings.len()), (&[O, U, F][..], 0));
    }
    // The first row of the image is the uppermost.
    let map = read(&yaml(""), &png(1, ColorType::Grayscale, BitDepth::Eight, &[0, 254])).unwrap();
    assert_eq!(map.cells(), [F, O]);
    let palette = {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, 3, 1);
        encoder.set_color(ColorType::Indexed);
        encoder.set_depth(BitDepth::Two);
        encoder.set_palette([0, 0, 0, 205, 205, 205, 255, 255, 255].to_vec());
        encoder.write_header().unwrap().write_image_data(&[0b0001_1000]).unwrap();
        bytes
    };
    assert_eq!(read(&yaml(""), &palette).unwrap().cells(), [O, U, F]);
}

/// GIMP writes colours into a file that is called map.pgm.
#[test]
fn coloured_netpbm_images_are_read() {
    let pixels = [[254, 254, 254], [0, 0, 0], [205, 205, 205], [3, 252, 255]];
    let binary = [b"P6\n4 1\n255\n".as_slice(), &pixels.concat()].concat();
    let plain: Vec<String> = pixels.concat().iter().map(u8::to_string).collect();
    for image in [binary, format!("P3 4 1 255 {}", plain.join("\n")).into_bytes()] {
        let cells = read(&yaml(""), &image).unwrap();
        assert_eq!(cells.cells(), [Cell::Free, Cell::Occupied, Cell::Unknown, Cell::Unknown]);
    }
}

/// A BMP image of so many bits a pixel, with its palette and its rows from the lowest one, each filled up to
/// a multiple of four bytes. A negative height says that the uppermost row comes first.
pub(super) fn bmp([columns, rows]: [i32; 2], bits: u16, palette: &[u8], rows_of: &[u8]) -> Vec<u8> {
    let offset = 14 + 40 + palette.len();
    let mut bytes = b"BM".to_vec();
    bytes.extend(u32::try_from(offset + rows_of.len()).unwrap().to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(u32::try_from(offset).unwrap().to_le_bytes());
    bytes.extend(40_u32.to_le_bytes());
    bytes.extend(columns.to_le_bytes());
    bytes.extend(rows.to_le_bytes());
    bytes.extend(1_u16.to_le_bytes());
    bytes.extend(bits.to_le_bytes());
    bytes.extend([0; 16]);
    bytes.extend(u32::try_from(palette.len() / 4).unwrap().to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend_from_slice(palette);
    bytes.extend_from_slice(rows_of);
    bytes
}

/// Every grey, as the palette of a BMP image of eight bits.
pub(super) fn greys() -> Vec<u8> {
    (0..=255).flat_map(|grey| [grey, grey, grey, 0]).collect()
}

/// Occupied, free and never seen, above a row that is free: in the kinds of BMP that GIMP and MATLAB write.
#[test]
fn bmp_images_of_every_kind_are_read() {
    let grey = [254, 254, 254, 0, 0, 254, 205, 0];
    // Blue, green and red of 3, 252 and 255 are 170 on average: neither free nor occupied.
    let colours = [[254; 3], [254; 3], [254; 3], [0; 3], [254; 3], [205; 3]];
    let rows = |row: &[[u8; 3]]| [row.concat(), vec![0; 3]].concat();
    let coloured = [rows(&colours[..3]), rows(&colours[3..])].concat();
    let palette = [255, 255, 255, 0, 1, 1, 1, 0, 205, 205, 205, 0];
    let indexed = [0, 0, 0, 0, 1, 0, 2, 0];
    let downwards = [rows(&colours[3..]), rows(&colours[..3])].concat();
    let wide = |row: &[[u8; 3]]| row.iter().flat_map(|bgr| [bgr[0], bgr[1], bgr[2], 0]).collect();
    let wide: Vec<Vec<u8>> = vec![wide(&colours[..3]), wide(&colours[3..])];
    for (kind, image) in [
        ("grey", bmp([3, 2], 8, &greys(), &grey)),
        ("a palette", bmp([3, 2], 8, &palette, &indexed)),
        ("24 bits", bmp([3, 2], 24, &[], &coloured)),
        ("24 bits from above", bmp([3, -2], 24, &[], &downwards)),
        ("32 bits", bmp([3, 2], 32, &[], &wide.concat())),
    ] {
        let map = read(&yaml(""), &image).unwrap_or_else(|error| panic!("{kind}: {error}"));
        assert_eq!([map.columns(), map.rows()], [3, 2], "{kind}");
        let row = |row| [0, 1, 2].map(|column| map.cell(column, row));
        assert_eq!(row(0), [Cell::Free; 3], "{kind}");
        assert_eq!(row(1), [Cell::Occupied, Cell::Free, Cell::Unknown], "{kind}");
    }
}

#[test]
fn a_bmp_that_claims_more_than_it_has_is_refused_in_one_line() {
    let whole = bmp([3, 2], 24, &[], &[254; 24]);
    for kept in [2, 20, 40, 54, 60, whole.len() - 4] {
        let refusal = read(&yaml(""), &whole[..kept]).unwrap_err().to_string();
        assert!(refusal.contains("the BMP image cannot be read"), "{kept}: {refusal}");
        assert!(!refusal.contains('\n'), "{kept}: {refusal}");
    }
    let refusal = read(&yaml(""), &bmp([60_000, 60_000], 24, &[], &[254; 24])).unwrap_err();
    assert!(refusal.to_string().contains("60000 by 60000 pixels"), "{refusal}");
}

#[test]
fn transparent_pixels_are_unknown_with_a_remark() {
    let pixels = [254, 255, 254, 128, 0, 0];
    let image = png(3, ColorType::GrayscaleAlpha, BitDepth::Eight, &pixels);
    for mode in ["", "mode: scale\n", "mode: raw\n"] {
        let map = read(&yaml(mode), &image).unwrap();
        assert_eq!(&map.cells()[1..], [U, U]);
        assert_eq!(map.warnings[0].to_string(), "m.pgm: 2 transparent pixels are taken as unknown");
    }
}

#[test]
fn a_png_that_claims_more_than_a_map_may_have_is_refused_by_its_header() {
    let mut image = png(1, ColorType::Grayscale, BitDepth::Eight, &[0]);
    // The width and the checksum of the header.
    image[16..20].copy_from_slice(&0x7fff_ffff_u32.to_be_bytes());
    let checksum = crc32(&image[12..29]);
    image[29..33].copy_from_slice(&checksum.to_be_bytes());
    let error = read(&yaml(""), &image).unwrap_err().to_string();
    assert!(error.contains("the header says 2147483647 by 1 pixels"), "{error}");
}

/// The checksum of a chunk of PNG, by its definition.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
}

/// The files of nav2's map_saver until 2025, of SLAM Toolbox which calls it, and one of Cartographer
/// with a threshold of one's own.
#[test]
fn what_was_never_seen_is_not_free_whatever_the_threshold_says() {
    let nav2 = |more: &str| yaml(more).replace("0.196", "0.25");
    let map = read(&nav2("mode: trinary\n"), b"P5 4 1 255\n\x00\xcd\xcd\xfe").unwrap();
    assert_eq!(map.cells(), [O, U, U, F]);
    assert_eq!(
        map.warnings[0].to_string(),
        "m.yaml:5: free_thresh = 0.25 makes grey 205 free, by which maps mark what was never seen: \
         its 2 cells are taken as unknown"
    );
    // The same grey of 16 bits; the next greys are free by the threshold.
    let map = read(&nav2(""), b"P5 3 1 65535\n\xcd\xcd\xcc\xcc\xce\xce").unwrap();
    assert_eq!(map.cells(), [U, F, F]);
    let own = yaml("").replace("0.196", "0.6").replace("0.65", "0.7");
    let map = read(&own, b"P5 4 1 255\n\x00\x80\x7f\xfe").unwrap();
    assert_eq!((map.cells(), map.warnings.len()), (&[O, U, U, F][..], 1));
    // In the mode `raw`, 205 is unknown by itself.
    let raw = read(&nav2("mode: raw\n"), b"P5 3 1 255\n\x00\xcd\x64").unwrap();
    assert_eq!((raw.cells(), raw.warnings.len()), (&[F, U, O][..], 0));
}

#[test]
fn a_mode_is_read_whatever_the_case_of_its_letters() {
    for mode in ["Trinary", "TRINARY", "trinary"] {
        assert!(read(&yaml(&format!("mode: {mode}\n")), b"P5 1 1 255\n\xfe").is_ok(), "{mode}");
    }
    let raw = read(&yaml("mode: Raw\n"), b"P5 1 1 255\n\xfe").unwrap();
    assert_eq!(raw.cells(), [U]);
}

/// As map_saver writes it where the SLAM's rotation is none.
#[test]
fn a_yaw_that_is_no_number_is_zero_with_a_remark() {
    for yaw in ["-nan", "nan", ".nan", "-nan(ind)", "NaN", "\"-nan\""] {
        let map = read(&yaml("").replace("0.0]", &format!("{yaw}]")), b"P5 1 1 255\n\xfe").unwrap();
        assert_eq!(map.origin, [-1.0, 2.0, 0.0]);
        let [remark] = &map.warnings[..] else { panic!("{:?}", map.warnings) };
        assert!(remark.to_string().starts_with("m.yaml:3: the yaw of the origin is "), "{remark}");
    }
}

#[test]
fn numbers_of_the_origin_are_read_in_every_spelling_of_the_map_savers() {
    for (text, place) in [
        ("[-51.224998, -51.224998, 0.000000]", [-51.224_998, -51.224_998, 0.0]),
        ("[-1, 2., 0.]", [-1.0, 2.0, 0.0]),
        ("[1e-05, -2.5e+01, +0.5]", [1e-5, -25.0, 0.5]),
        ("[\"-1.0\", '2', 0]", [-1.0, 2.0, 0.0]),
        ("\n- -1.0\n- 2.0\n- 0", [-1.0, 2.0, 0.0]),
    ] {
        let text = yaml("").replace("[-1.0, 2.0, 0.0]", text);
        let map = read(&text, b"P5 1 1 255\n\xfe").unwrap();
        assert_eq!((map.origin, map.warnings.len()), (place, 0), "{text}");
    }
}

#[test]
fn the_path_of_another_machine_leads_to_the_file_beside() {
    for path in ["/home/robot/maps/m.pgm", "C:\\\\maps\\\\m.pgm", "../maps/m.pgm"] {
        let text = yaml("").replace("image: m.pgm", &format!("image: \"{path}\""));
        let map = read(&text, b"P5 1 1 255\n\xfe").unwrap();
        assert_eq!(map.warnings.len(), 1, "{path}");
        assert!(map.warnings[0].to_string().contains("m.pgm beside this file is read"));
    }
}

#[test]
fn bad_input_is_refused_with_place_and_remedy() {
    let white = b"P5 1 1 255\n\xfe".as_slice();
    for (text, image, told) in [
        (yaml("mode: cubic\n"), white, "m.yaml:6: there is no mode \"cubic\"; give trinary"),
        (yaml("").replace("0.05", "-1"), white, "m.yaml:2: resolution = -1 is out of range"),
        (yaml("").replace("0.65", "0.1"), white, "m.yaml:5: free_thresh = 0.196 is above"),
        (yaml("").replace("m.pgm", "n.pgm"), white, "m.yaml:1: there is no image \"n.pgm\"; put"),
        (yaml("").replace("[-1.0, 2.0, 0.0]", "[1]"), white, "m.yaml:3: origin has 1 numbers"),
        ("image: m.pgm\n".into(), white, "m.yaml: it has no resolution"),
        ("- 1\n- 2\n".into(), white, "this is no map of map_server"),
        (yaml(""), b"BM\x00\x00", "the BMP image cannot be read: "),
        (yaml(""), b"GIF89a", "the image is a GIF; save it as PGM, PNG or BMP"),
        (yaml(""), b"\x89PNG\r\n\x1a\nhalf", "the PNG image cannot be read: "),
        (yaml("").replace("2.0", "nan"), white, "m.yaml:3: the y of the origin is \"nan\", which"),
        (yaml("").replace("2.0", "north"), white, "m.yaml:3: the y of the origin is \"north\","),
        (yaml("").replace(" 0.0]", " left]"), white, "m.yaml:3: the yaw of the origin is \"left\""),
        (
            yaml(""),
            b"P4 1 1\n\xfe",
            "m.pgm: only PGM, PPM, PNG and BMP are read, and the image is another kind of Netpbm; save",
        ),
        (yaml(""), b"", "m.pgm: the image is empty; copy or save it again"),
        (yaml(""), b"version https://git-lfs.github.com/spec/v1\n", "pointer that Git LFS leaves"),
        (yaml(""), b"P6 1 1 255\n\xfe\xfe", "needs 3 bytes of pixels, and 2 are left"),
        (yaml(""), b"P5\n9 9\n255\n\xfe", "the header needs 81 bytes of pixels, and 1 are left"),
        (yaml(""), b"P5\n99999 99999\n255\n", "m.pgm:3: the header says 99999 by 99999 pixels"),
        (yaml(""), b"P5\n-4 9\n255\n", "m.pgm:2: the image has no width here"),
        (yaml(""), b"P5 1 1 70000\n\xfe", "the image has no largest value here"),
        (yaml(""), b"P2 2 1 255 1 256", "the image has no pixel here"),
    ] {
        let error = read(&text, image).unwrap_err().to_string();
        assert!(error.contains(told) && error.lines().count() == 1, "{error}");
    }
}

#[test]
fn keys_of_another_version_are_passed_over_and_missing_thresholds_are_the_usual_ones() {
    let text = "image: m.pgm\nresolution: 0.05\norigin: [0, 0]\nnegate: 0\nlayers: {a: 1}\n";
    let map = read(text, b"P5 1 1 255\n\xfe\x00\x00").unwrap();
    assert_eq!(map.cells(), [F]);
    let told: Vec<_> = map.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        told,
        [
            "m.yaml: it has no occupied_thresh: 0.65 is taken",
            "m.yaml: it has no free_thresh: 0.196 is taken",
            "m.pgm: 2 bytes behind the image are not read",
        ]
    );
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn what_is_written_is_read_back(
        columns in 1usize..9,
        cells in prop::collection::vec(prop::sample::select(vec![F, O, U]), 1..60),
        resolution in 0.01f64..2.0,
        origin in prop::array::uniform3(-90.0f64..90.0),
    ) {
        let map = Occupancy::new(columns.min(cells.len()), cells, resolution, origin);
        let (mut yaml, mut image) = (Vec::new(), Vec::new());
        map_server::write(&map, &mut yaml, &mut image).unwrap();
        let files = Memory::default().with("a.yaml", yaml).with(map_server::IMAGE, image);
        prop_assert_eq!(map_server::read(&files, "a.yaml").unwrap(), map);
    }

    #[test]
    fn no_bytes_make_a_reader_panic(yaml in "\\PC{0,200}", image: Vec<u8>) {
        let _ = read(&yaml, &image);
        let _ = read(&self::yaml(""), &[b"P5 ", &*image].concat());
        let _ = read(&self::yaml(""), &[b"\x89PNG\r\n\x1a\n", &*image].concat());
    }
}
