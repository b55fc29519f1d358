// Baked drives with their inputs, for the binaries `baked_trials` and `baked_budget`; tests build them with others.

drives! {
    press "paper's model": (Recorded, "recorded: no effect") (Random, "random: no effect");
}

#[allow(dead_code, unreachable_pub, reason = "a binary needs a part of what is for anybody")]
mod press {
    include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../baked.rs"));
}
