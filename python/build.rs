//! How the module is linked: on macOS its Python is found where it is loaded, which the linker must be told; `maturin` would, a plain `cargo build` does not.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
