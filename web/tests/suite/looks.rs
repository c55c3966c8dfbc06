//! How the page looks: readable on a phone and on a wide screen, light and dark.

use crate::browser::{Browser, LEAST_CONTRAST};
use crate::opened::{folder, open};

/// The least contrast of a text with its background that WCAG 2.2 asks for at level AA.
const CONTRAST: f64 = 4.5;

/// The widths of a screen and of a phone, pixels, each in both colour schemes.
pub(crate) const LOOKS: [(u32, &str); 4] =
    [(1_440, "light"), (1_440, "dark"), (400, "light"), (400, "dark")];

/// Shows the page so, and fails where a text is pale or the page is wider than the screen.
pub(crate) async fn is_readable(browser: &mut Browser, name: &str, (width, scheme): (u32, &str)) {
    browser.look(width, scheme).await;
    let contrast = browser.evaluate(LEAST_CONTRAST).await.as_f64().unwrap();
    assert!(contrast >= CONTRAST, "{name}, {width}, {scheme}: {contrast}");
    let needed = browser.evaluate("document.documentElement.scrollWidth").await;
    assert!(needed.as_u64().unwrap() <= u64::from(width), "{name}, {width}: {needed}");
}

#[tokio::test]
async fn the_page_is_readable_narrow_and_wide_light_and_dark_in_chromium() {
    let mut browser = open("looks", "").await;
    browser.wait_for("uchain.page.frame.t > 60").await;
    browser.evaluate("document.getElementById('ask').click()").await;
    browser.wait_for("document.querySelectorAll('#answer tr').length > 2").await;
    let nameless = "[...document.querySelectorAll('button, input, select')].filter((e) => \
                    !(e.innerText?.trim() || e.labels?.length)).length";
    assert_eq!(browser.evaluate(nameless).await, 0);
    let pictures = folder("pictures");
    for (width, scheme) in LOOKS {
        is_readable(&mut browser, "the page", (width, scheme)).await;
        browser.picture(&pictures.join(format!("page-{width}-{scheme}.png.base64"))).await;
    }
}
