//! A camera as text from which it is restored bit for bit.

use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};

/// JSON; every f64 with the shortest digits that give it back exactly. `None` if a number is not finite.
pub(crate) fn text_from_camera(camera: &Camera) -> Option<String> {
    let text = serde_json::to_string(camera).ok()?;
    // JSON has no word for NaN or infinity: it would write null
    (camera_from_text(&text).ok()? == *camera).then_some(text)
}

/// The camera of such a text; an error says why it is none.
pub(crate) fn camera_from_text(text: &str) -> Result<Camera, String> {
    let camera: Camera = serde_json::from_str(text).map_err(|error| error.to_string())?;
    check(&camera).map_err(|error| error.to_string())?;
    // A frame that was built by normalising is off by a rounding or two
    const LOOSE: f64 = 1e-6;
    let (e1, e2, m) = (camera.iris.e1(), camera.iris.e2(), camera.iris.normal());
    let off = [e1.length() - 1.0, e2.length() - 1.0, m.length() - 1.0, e1.dot(e2), e1.dot(m), e2.dot(m)];
    // NaN is not within any bound
    if !off.iter().all(|x| x.abs() <= LOOSE) {
        return Err("the iris axes are not perpendicular unit vectors".into());
    }
    Ok(camera)
}

/// Asks the constructors whether they would have made such a camera.
fn check(camera: &Camera) -> Result<(), optics::OpticsError> {
    let Camera { pose, film, focus, iris } = camera;
    Pose::new(pose.position, pose.right, pose.up, pose.forward)?;
    Film::new(film.min(), film.max(), film.width(), film.height())?;
    Focus::new(focus.w())?;
    Iris::new(iris.normal(), iris.radius(), iris.shape())?;
    if let ApertureShape::Polygon { blades, rotation } = iris.shape() {
        ApertureShape::polygon(blades, rotation)?;
    }
    Ok(())
}
