//! lacuna-close
