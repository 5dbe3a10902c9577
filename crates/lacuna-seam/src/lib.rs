//! lacuna-seam
