//! Files of the outside world, one file each. Text and bytes in, values out: nobody here opens a file.

pub mod belt_svg;
pub mod camera_file;
pub mod cameras_json;
pub mod colmap;
pub mod corrections_toml;
pub mod gltf;
pub mod growth_csv;
pub mod json;
pub mod metashape;
pub mod ome_zarr;
pub mod opencv_lens;
pub mod photograph;
pub mod picture;
pub mod ply;
pub mod points_csv;
pub mod recalled_csv;
pub mod roots_json;
pub mod rsml;
pub mod swc;
pub mod tables;
pub mod tank_json;
pub mod transforms_json;

pub use cameras_json::NamedView;
