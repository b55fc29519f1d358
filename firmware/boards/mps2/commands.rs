// Commands that `budget` counts the paper's model under beside its own, each by a name and in V, one a tick. FIRMWARE_COMMANDS names another
// file; `benches/run` writes one with the signals of what it compares with.
[]
