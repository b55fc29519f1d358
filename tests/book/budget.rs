//! Do the tables of `docs/target.md` have the figures that were measured on the emulated boards?

use std::collections::BTreeMap;
use std::fs;

use crate::root;

/// A board's figures in the snapshot, by name.
struct Board(BTreeMap<String, f64>);

impl Board {
    fn of(name: &str) -> Self {
        let snapshot = fs::read_to_string(root().join("tests/on_target/budget.txt")).unwrap();
        let (_, figures) = snapshot.split_once(&format!("\n{name}\n")).unwrap();
        let (figures, _) = figures.split_once("\nwanted:").unwrap();
        let figure = |line: &str| {
            let (name, value) = line.rsplit_once(' ').unwrap();
            (name.trim_end().to_owned(), value.parse().unwrap())
        };
        Self(figures.lines().map(figure).collect())
    }

    fn figure(&self, name: &str) -> f64 {
        *self.0.get(name).unwrap_or_else(|| panic!("budget.txt has no {name}"))
    }

    fn step(&self, which: &str, model: &str) -> f64 {
        self.figure(&format!("instructions a step, {which}: {model}"))
    }

    /// Mean and worst of a period.
    fn period(&self, name: &str) -> String {
        let [mean, worst] =
            ["mean", "worst"].map(|which| whole(self.figure(&format!("instructions a period, {which}: {name}"))));
        format!("{mean}, {worst}")
    }

    fn bytes(&self, name: &str) -> String {
        format!("{} B", self.figure(name))
    }

    fn kilobytes(&self, name: &str, digits: usize) -> String {
        format!("{:.digits$} KB", self.figure(name) / 1000.0)
    }
}

/// A number as in the tables: with a space between thousands from 10 000 on.
fn whole(value: f64) -> String {
    let digits = value.to_string();
    match digits.len().checked_sub(3) {
        Some(thousands @ 2..) => format!("{} {}", &digits[..thousands], &digits[thousands..]),
        _ => digits,
    }
}

/// Mean instructions of a baked drive under random commands, without and with loads.
fn of_baked(board: &Board, model: &str) -> String {
    ["random", "under load"].map(|input| board.step("mean", &format!("baked, {model}, {input}")).to_string()).join(", ")
}

/// Flash of images of baked drives.
fn flash_of_baked(board: &Board, numbers: &str) -> String {
    let flash = |model: &str| board.kilobytes(&format!("flash of a whole image, bytes: baked, {numbers}{model}"), 1);
    ["paper's model", "three effects", "every effect"].map(flash).join(", ")
}

/// A row's name, and its cell for a board.
type Row = (&'static str, fn(&Board) -> String);

const ROWS: [Row; 19] = [
    ("paper's model, instructions a tick: mean by input, worst", |board| {
        let [least, most] =
            ["steps", "random under load"].map(|input| board.step("mean", &format!("paper's model, {input}")));
        format!("{least} to {most}, {}", board.step("worst", "paper's model, random under load"))
    }),
    ("every effect at once, mean", |board| board.step("mean", "every effect, random under load").to_string()),
    ("one effect at a time, mean: least, supply droop", |board| {
        format!("{}, {}", board.step("mean", "sensor-offset"), board.step("mean", "supply-droop"))
    }),
    ("flash of the step: paper's model by itself", |board| {
        board.kilobytes("flash of the step, bytes: paper's model", 1)
    }),
    ("flash of the step: any drive, every effect included", |board| {
        board.kilobytes("flash of the step, bytes: every effect", 1)
    }),
    ("RAM: state, beside its delay lines (two of 256 bytes)", |board| {
        board.bytes("RAM, bytes: state beside its delay lines")
    }),
    ("RAM: that and the coefficients, paper's model by itself", |board| {
        board.bytes("RAM beside the delay lines, bytes: paper's model")
    }),
    ("RAM: that and the coefficients, any drive", |board| {
        board.bytes("RAM beside the delay lines, bytes: every effect")
    }),
    ("baked, paper's model: instructions by input", |board| of_baked(board, "paper's model")),
    ("baked, three effects of three links", |board| of_baked(board, "three effects")),
    ("baked, five effects of four links", |board| of_baked(board, "five effects")),
    ("baked, five effects, two of which make the edges differ", |board| of_baked(board, "five effects with edges")),
    ("baked: flash of a whole image, paper's model, three effects, every effect", |board| flash_of_baked(board, "")),
    ("baked: RAM, state and stack beside the delay lines, paper's model, five effects", |board| {
        let ram = |model: &str| board.bytes(&format!("RAM, bytes: baked, {model}: state and stack"));
        ["paper's model", "five effects"].map(ram).join(", ")
    }),
    ("stack: paper's model, every effect", |board| {
        format!("{}, {}", board.bytes("stack, bytes: paper's model"), board.bytes("stack, bytes: every effect"))
    }),
    ("period while it follows, paper's model: mean, worst", |board| board.period("following")),
    ("worst of faults, their ramps and the way back", |board| {
        board.figure("instructions a period, worst: faults and the way back").to_string()
    }),
    ("period with every effect in the model: mean, worst", |board| board.period("following, every effect")),
    ("flash of the control period, every effect included", |board| {
        board.kilobytes("flash of the control period, every effect included, bytes", 0)
    }),
];

/// Rows of the whole firmware, with the end of a board's cell.
const OF_LOOP: [Row; 2] = [
    ("flash of `loop`: with start-up in soft float and its errors in words", |board| {
        board.kilobytes("flash of the whole firmware, bytes", 0)
    }),
    ("RAM of `loop`: recorder's rows, else, stack from start to end", |board| {
        format!("{} B", whole(board.figure("stack, bytes: whole firmware, from its start to its end")))
    }),
];

/// A row of the number types: its name, its cell for the numbers with this prefix, and what is wanted of single precision.
type NumberRow = (&'static str, fn(&Board, &str) -> String, &'static str);

/// Fixed point and single precision on the Cortex-M4F.
const OF_NUMBERS: [NumberRow; 13] = [
    (
        "paper's model, instructions a tick: mean by input, worst",
        |board, numbers| {
            let [least, most] = ["steps", "random under load"]
                .map(|input| board.step("mean", &format!("{numbers}paper's model, {input}")));
            let worst = board.step("worst", &format!("{numbers}paper's model, random under load"));
            format!("{least} to {most}, {worst}")
        },
        "400: **not met**",
    ),
    (
        "three effects of three links, mean",
        |board, numbers| several(board, numbers, "three effects"),
        "900: **not met**",
    ),
    ("five effects of four links, mean", |board, numbers| several(board, numbers, "five effects"), "900: **not met**"),
    (
        "five effects, two of which make the edges differ, mean",
        |board, numbers| several(board, numbers, "five effects with edges"),
        "900: **not met**",
    ),
    (
        "every effect at once, mean",
        |board, numbers| several(board, numbers, "every effect, random under load"),
        "3000: **not met**",
    ),
    (
        "flash of the step: paper's model by itself",
        |board, numbers| board.kilobytes(&format!("flash of the step, bytes: {numbers}paper's model"), 1),
        "",
    ),
    (
        "flash of the step: any drive, every effect included",
        |board, numbers| board.kilobytes(&format!("flash of the step, bytes: {numbers}every effect"), 1),
        "",
    ),
    ("baked, paper's model", |board, numbers| of_baked(board, &format!("{numbers}paper's model")), "400: met"),
    (
        "baked, three effects of three links",
        |board, numbers| of_baked(board, &format!("{numbers}three effects")),
        "900: met",
    ),
    (
        "baked, five effects of four links",
        |board, numbers| of_baked(board, &format!("{numbers}five effects")),
        "900: met",
    ),
    (
        "baked, five effects, two of which make the edges differ",
        |board, numbers| of_baked(board, &format!("{numbers}five effects with edges")),
        "",
    ),
    ("baked, every effect", |board, numbers| of_baked(board, &format!("{numbers}every effect")), "3000: **not met**"),
    (
        "baked: flash of a whole image, paper's model, three effects, every effect",
        |board, numbers| flash_of_baked(board, numbers),
        "",
    ),
];

fn several(board: &Board, numbers: &str, effects: &str) -> String {
    board.step("mean", &format!("{numbers}{effects}")).to_string()
}

#[test]
fn the_table_of_number_types_is_that_of_the_snapshot() {
    let page = fs::read_to_string(root().join("docs/target.md")).unwrap();
    let board = Board::of("Cortex-M4F");
    for (name, cell, wanted) in OF_NUMBERS {
        let row = format!("| {name} | {} | {} | {wanted} |", cell(&board, ""), cell(&board, "f32, "));
        assert!(page.contains(&row), "docs/target.md has not:\n{row}");
    }
}

#[test]
fn the_tables_of_the_target_are_those_of_the_snapshot() {
    let page = fs::read_to_string(root().join("docs/target.md")).unwrap();
    let boards = ["Cortex-M4F", "Cortex-M3"].map(Board::of);
    for (name, cell) in ROWS {
        let row = format!("| {name} | {} |", boards.each_ref().map(cell).join(" | "));
        assert!(page.contains(&row), "docs/target.md has not:\n{row}");
    }
    for (name, cell) in OF_LOOP {
        let row = page.lines().find_map(|line| line.strip_prefix(&format!("| {name} | ")));
        let row = row.unwrap_or_else(|| panic!("docs/target.md has no row {name}"));
        for (cell, shown) in boards.each_ref().map(cell).iter().zip(row.split(" | ")) {
            assert!(shown.ends_with(cell.as_str()), "{name}: {shown} for {cell}");
        }
    }
}
