//! Shares of a sample and their union.

use super::*;
use stiffmap::sweep::shards::Shard;

#[test]
fn shards_are_consecutive_and_nearly_equal() {
    for (designs, of) in [(24, 3), (200, 7), (5, 8), (1, 1)] {
        let mut next = 0;
        for number in 1..=of {
            let range = Shard { number, of }.range(designs);
            assert_eq!(range.start, next);
            assert!(range.end - range.start <= designs / of + 1);
            next = range.end;
        }
        assert_eq!(next, designs);
    }
    for text in ["0/3", "4/3", "3", "a/b", "1/0", "-1/3"] {
        assert!(text.parse::<Shard>().is_err(), "{text}");
    }
    assert_eq!("2/3".parse(), Ok(Shard { number: 2, of: 3 }));
}

#[test]
fn three_shards_joined_are_the_table_of_one_run() {
    let folder = folder_with(STUDY);
    let path = folder.path();
    for (shard, out) in [("2/3", "b"), ("3/3", "c"), ("1/3", "a")] {
        done(&sweep(path, out, &["--shard", shard]));
    }
    assert_ne!(table(path, "a"), reference());
    done(&sweep(path, "whole", &["--merge", "b", "a", "c"]));
    assert_eq!(table(path, "whole"), reference());
    assert!(path.join("whole/pareto.csv").exists());
    let mut drawn = stiffmap();
    drawn.current_dir(path).args([
        "sweep",
        "study.toml",
        "--out",
        "drawn",
        "--sensitivities=3",
        "--merge",
        "b",
        "a",
        "c",
    ]);
    done(&drawn.output().unwrap());
    assert_eq!(table(path, "drawn"), reference());
    for file in ["figures/best_over_position.png", "figures/front.png", "sensitivities.csv"] {
        assert!(path.join("drawn").join(file).is_file(), "{file}");
    }

    let refused = |folders: &[&str], fragments: &[&str]| {
        let output = sweep(path, "refused", &[&["--merge"], folders].concat());
        assert_eq!(output.status.code(), Some(2), "{folders:?}");
        let said = stderr(&output);
        assert!(fragments.iter().all(|f| said.contains(f)), "{fragments:?} are not in {said}");
        assert!(!path.join("refused/designs.csv").exists());
    };
    refused(&["a", "c"], &["designs 8 to 15", "no shard covers them"]);
    refused(&["a", "b"], &["designs 16 to 23"]);
    refused(&["a", "b", "c", "b"], &["designs 8 to 15 are in b and in b"]);
    refused(&["a", "b", "c", "whole"], &["are in"]);
    refused(&["a", "b", "d"], &["d/sweep.json", "not the record of a sweep"]);

    // A shard of which rows are missing, and one of another study.
    let text = table(path, "c");
    let cut = text.trim_end().rfind('\n').unwrap() + 1;
    std::fs::write(path.join("c/designs.csv"), &text[..cut]).unwrap();
    refused(&["a", "b", "c"], &["designs 23 to 23", "c is not finished"]);
    std::fs::write(path.join("c/designs.csv"), &text).unwrap();
    let other = folder_with(&changed("seed = 7", "seed = 8"));
    done(&sweep(other.path(), "c", &["--shard", "3/3"]));
    let foreign = other.path().join("c");
    refused(&["a", "b", foreign.to_str().unwrap()], &["the hash of study.toml is"]);
}
