use super::super::testing::input;
use super::*;
use crate::recording::{Recording, RecordingInfo};
use crate::sample::GazeSample;
use proptest::prelude::*;

fn table(input: &Input) -> Table<'_> {
    Table::open(input, &["t", "x"], &["t", "x"]).expect("a table")
}

/// Reads `t` in ms; `x` goes to the extra columns.
fn read(text: &str) -> Result<Recording> {
    let input = input(text);
    let mut table = Table::open(&input, &["t", "x"], &["t", "x"])?;
    let time = table.take("t");
    read_rows(&table, RecordingInfo::default(), |row| {
        Ok(GazeSample::at(row.time_ns(time, 1e6).ok_or("there is no time")?))
    })
}

fn skipped(recording: &Recording) -> Vec<(u64, &str)> {
    recording.info.skipped.iter().map(|skipped| (skipped.rows, skipped.why.as_str())).collect()
}

#[test]
fn delimiters_marks_and_line_ends_of_all_kinds_read_alike() {
    let plain = read("t,x\n1,0.5\n2,\n3,1.5\n").expect("plain");
    for text in [
        "t;x\n1;0,5\n2;\n3;1,5\n",
        "t\tx\r\n1\t0.5\r\n2\tNaN\n3\t1.5\r",
        "\u{feff}t,x\n1,0.5\n2,-nan(ind)\n\n3,1.5",
        "\"t\",\"X\"\n1,\"0,5\"\n2,\".\"\n3,\"1.5\"\n",
        "made by a recorder\nsubject: 7, run: 2\n\nT [ms];X [deg]\n1;0.5\n2;\n3;1.5\n",
        "t x\n1 0.5\n2 nan\n3   1.5\n",
        "1,0.5\n2,\n3,1.5\n",
        "t,x,\n1,0.5,\n2,,\n3,1.5,\n",
    ] {
        let other = read(text).unwrap_or_else(|error| panic!("{text:?}: {error}"));
        assert_eq!(other.times_ns(), plain.times_ns(), "{text:?}");
        let values = |recording: &Recording| -> Vec<Option<u64>> {
            let column = recording.extra.first().map(|column| column.values.clone()).unwrap_or_default();
            column.iter().map(|value| (!value.is_nan()).then(|| value.to_bits())).collect()
        };
        assert_eq!(values(&other), values(&plain), "{text:?}");
        assert_eq!(skipped(&other), [], "{text:?}");
    }
}

#[test]
fn rows_that_are_none_are_counted_with_an_example() {
    let recording = read("t,x\n1,2\n2\n3,4,5\nlate,6\n,7\n7,text\n8,9\n9").expect("some are good");
    assert_eq!(recording.times_ns(), [1_000_000, 7_000_000, 8_000_000]);
    assert_eq!(
        skipped(&recording),
        [
            (2, "there is no time, first in line 5"),
            (2, "the row has not the 2 fields of the header but, as the first, 1, first in line 3"),
            (1, "the file breaks off in line 9"),
        ]
    );
    let extra = recording.extra_column("x").expect("mostly numbers");
    assert!(extra[0] == 2.0 && extra[1].is_nan() && extra[2] == 9.0);
}

#[test]
fn a_header_without_samples_is_an_error_that_says_so() {
    for text in ["t,x\n", "t,x\r\n\r\n", "t,x"] {
        let error = read(text).expect_err("no samples").to_string();
        assert!(error.contains("holds a header but no samples"), "{error}");
    }
    let error = read("t,x\n,1\n,2\n").expect_err("no times").to_string();
    assert!(error.contains("2 rows were left out: there is no time, first in line 2"), "{error}");
    let error = read("a,b,c\n1,2,3\n").expect_err("another table").to_string();
    assert!(error.contains("no header line with the columns t, x"), "{error}");
}

#[test]
fn names_are_matched_with_and_without_units() {
    let input = input("Time(100ns);TIME (Player) ;  Pupil Radius (mm)  left;t;x [DACS mm];x [DACS px]\n");
    let table = table(&input);
    assert_eq!(table.find("time(100ns)"), Some(0));
    assert_eq!(table.find("time (player)"), Some(1));
    assert_eq!(table.find("time"), Some(0), "the first of several");
    assert_eq!(table.find("pupil radius left"), Some(2));
    assert_eq!(table.unit(Some(2)), "mm");
    assert_eq!(table.find_with_unit("x", &["dacspx"]), Some(5));
    assert_eq!((table.find("y"), table.unit(None)), (None, ""));
}

#[test]
fn columns_of_text_are_left_out_and_named() {
    let mut text = "t,x,who,on\n".to_owned();
    for time in 0..200 {
        text += &format!("{time},1,someone,True\n");
    }
    let recording = read(&text).expect("well formed");
    assert_eq!(recording.extra.iter().map(|extra| extra.name.as_str()).collect::<Vec<_>>(), ["x", "on"]);
    assert!(recording.extra[1].values.iter().all(|value| *value == 1.0));
    assert_eq!(recording.info.notes, ["columns of text were left out: who"]);
}

#[test]
fn the_last_rows_are_as_good_as_the_first() {
    let mut text = "t,x\n".to_owned();
    for time in 0..5000 {
        text += &format!("{time},{}\n", f64::from(time) * 0.25);
    }
    let recording = read(&text).expect("well formed");
    assert_eq!(recording.len(), 5000);
    assert_eq!(recording.extra_column("x").map(|values| values[4999]), Some(1249.75));
}

proptest! {
    /// Any bytes below a header read without a panic, and every row is a sample or told.
    #[test]
    fn every_row_is_a_sample_or_accounted_for(body in "[0-9,.;\"nat\n\r -]{0,200}") {
        if let Ok(recording) = read(&format!("t,x\n{body}")) {
            let told: u64 = recording.info.skipped.iter().map(|skipped| skipped.rows).sum();
            let lines = body.split(['\n', '\r']).filter(|line| line.split(',').any(|field| !field.is_empty()));
            prop_assert_eq!(recording.len() as u64 + told, lines.count() as u64);
        }
    }
}
