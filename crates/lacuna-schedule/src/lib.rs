//! lacuna-schedule
