"""What other tools read from a file that was written: `mat FILE`, `parquet FILE`. A line a variable: its name and all values."""

import sys


def mat(path):
    import scipy.io

    for name, values in scipy.io.loadmat(path).items():
        # What it keeps of the file itself.
        if not name.startswith("__"):
            assert values.shape[1] == 1, (name, values.shape)
            yield name, values[:, 0]


def parquet(path):
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    for name in table.column_names:
        yield name, table[name].to_pylist()


for name, values in {"mat": mat, "parquet": parquet}[sys.argv[1]](sys.argv[2]):
    print(name, *("none" if value is None or value != value else repr(float(value)) for value in values), sep="\t")
