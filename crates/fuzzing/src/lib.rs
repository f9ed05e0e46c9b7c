//! Every reader behind one kind of entry point, for whatever makes damaged files: `cargo fuzz` (`fuzz/`), or this crate's own command where
//! no nightly compiler is at hand.

pub mod mutation;
pub mod seeds;
mod target;

pub use target::{Target, run, target, targets};

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::mutation::{Random, mutated};

    #[test]
    fn two_hundred_damaged_files_of_every_kind_are_survived() {
        for target in super::targets() {
            let seeds = super::seeds::seeds(&target);
            let mut random = Random::new(24);
            for number in 0..200 {
                let bytes = mutated(&seeds, &mut random);
                let start = Instant::now();
                target.run(&bytes);
                assert!(start.elapsed() < Duration::from_secs(10), "{} {number}", target.name);
            }
        }
    }

    #[test]
    fn every_target_is_one_of_cargo_fuzz_too() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz");
        let manifest = std::fs::read_to_string(format!("{folder}/Cargo.toml")).unwrap();
        for target in super::targets() {
            let file = format!("fuzz_targets/{}.rs", target.name);
            assert!(manifest.contains(&format!("path = \"{file}\"")), "{file} is not in fuzz/Cargo.toml");
            let text = std::fs::read_to_string(format!("{folder}/{file}")).unwrap();
            assert!(text.contains(&format!("run(\"{}\", bytes)", target.name)), "{file}");
        }
    }
}
