//! Two pictures to error figures, masks, heat maps and a report page.
