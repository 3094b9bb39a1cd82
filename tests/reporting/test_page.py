"""The page: whole, self-contained, escaped, and saying what the plan and certificate say."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from pivotgait.exceptions import InputError
from pivotgait.reporting import Picture, Trials, render_report, write_report
from tests.plotting.knife_gait import knife_plan

VOID = {"meta", "img", "br", "source", "link", "input", "hr"}


class Page(HTMLParser):
    """Collects tags, attributes and text, and refuses tags that do not nest."""

    def __init__(self, text):
        super().__init__()
        self.open, self.seen, self.words = [], [], []
        self.feed(text)
        self.close()
        assert not self.open, f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.seen.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open[-1:] == [tag], f"</{tag}> closes {self.open[-1:]}"
        self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.words.append(data)

    def tags(self, name):
        return [attributes for tag, attributes in self.seen if tag == name]

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


@pytest.fixture
def page(plan, certificate, figures):
    return Page(render_report(plan, certificate, figures))


def test_opens_with_the_verdict_one_picture_and_one_table(page, plan):
    order = [tag for tag, _ in page.seen if tag in ("h1", "img", "table", "details")]
    assert order[:4] == ["h1", "img", "table", "details"]
    assert "Valid gait All 2 checks" in page.text
    for phase in plan.phases:
        assert phase.name in page.text


def test_needs_nothing_from_elsewhere(plan, certificate, figures):
    text = render_report(plan, certificate, figures)
    assert not re.search(r"https?://|//[a-z]|@import|url\(", text)
    page = Page(text)
    assert not page.tags("script")
    assert not page.tags("link")
    for attributes in (a for _, a in page.seen):
        for name in ("src", "srcset", "href", "data", "poster"):
            assert attributes.get(name, "data:").startswith("data:")


def test_every_picture_has_words(page, figures):
    assert [image["alt"] for image in page.tags("img")] == [f.alt for f in figures.values()]
    for figure in figures.values():
        assert figure.caption in page.text


def test_a_phone_gets_the_narrow_picture(page):
    (source,) = page.tags("source")
    assert source["srcset"].startswith("data:image/webp;base64,")
    assert "max-width" in source["media"]


def test_every_check_stands_beside_its_limit(page):
    assert "3.2 × 10⁻⁹ N ≤ 10⁻⁶ N 03_removal, 0.5 s yes" in page.text
    assert "0.012 N ≥ −10⁻⁸ N" in page.text


def test_phase_table_tells_units_and_an_unknown_time_as_a_dash(plan, certificate, figures):
    text = Page(render_report(plan, certificate, figures, plan_times={"00_lift": 0.0123})).text
    assert "00_lift lift – 0.80 s 0.0123 s" in text
    assert "01_relocation relocation middle 0.50 s –" in text
    assert "20.0°" in text


def test_invalid_plan_says_which_check_fails_where(plan, certificate, figures):
    certificate |= {
        "valid": False,
        "violations": [
            {"what": "force_balance_n", "phase": "00_lift", "value": 0.25, "limit": 1e-6,
             "contact": "", "time_s": 0.125},
            {"what": "cone_margin_n", "phase": "00_lift", "value": None, "limit": -1e-8,
             "contact": "thumb", "time_s": None},
        ],
    }  # fmt: skip
    page = Page(render_report(plan, certificate, figures))
    assert "Not a valid gait 2 checks fail; first: residual of (3), forces, 0.25 N" in page.text
    assert "Violations (2)" in page.text
    assert "00_lift, thumb" in page.text
    assert "Valid gait" not in page.text


@pytest.mark.parametrize("certificate", [None, {}])
def test_without_certificate_nothing_is_claimed(certificate, plan, figures):
    text = Page(render_report(plan, certificate, figures)).text
    assert "Not certified" in text
    assert "Valid gait" not in text


def test_certificate_of_another_release_is_shown_with_what_is_known(plan, figures):
    text = Page(render_report(plan, {"valid": True, "residuals": {"new_thing": 1.0}}, figures)).text
    assert "new thing" in text


def test_hostile_text_is_only_text(certificate):
    nasty = '"><script>alert(1)</script><img src=x onerror=alert(2)>&{{ 7*7 }}'
    plan = knife_plan(scene=f"name: {nasty}\n")
    plan = replace(plan, tool=replace(plan.tool, name=nasty), versions={nasty: nasty})
    certificate |= {"violations": [{"what": nasty, "phase": nasty, "contact": nasty}]}
    certificate |= {"valid": False, "residuals": {nasty: 1.0}}
    picture = Picture(b"\x89PNG", alt=nasty, caption=nasty)
    trials = [Trials(simulator=nasty, controller=nasty, trials=1, passed=0)]
    page = Page(render_report(plan, certificate, {"hero": picture}, validations=trials))
    assert not page.tags("script")
    assert [image["alt"] for image in page.tags("img")] == [nasty]
    assert nasty in page.text
    assert "49" not in page.text


def test_trials_are_told_with_their_interval(plan, certificate, figures):
    trials = Trials.model_validate(
        {"simulator": "pybullet", "controller": "hybrid", "trials": 10, "passed": 9, "rate": 0.9,
         "wilson_95": [0.596, 0.982], "stages": [{"name": "00_lift", "reached": 10, "passed": 9}]}
    )  # fmt: skip
    text = Page(render_report(plan, certificate, figures, validations=[trials])).text
    assert "pybullet, hybrid control: 9 of 10 passed" in text
    assert "0.596 to 0.982" in text


def test_page_is_written_whole_into_a_new_folder(plan, certificate, figures, tmp_path):
    path = write_report(tmp_path / "new", plan, certificate, figures)
    assert path == tmp_path / "new" / "report.html"
    assert [entry.name for entry in path.parent.iterdir()] == ["report.html"]
    assert path.read_text(encoding="utf-8") == render_report(plan, certificate, figures)


def test_a_failure_leaves_the_old_page_and_no_trace(
    plan, certificate, figures, tmp_path, monkeypatch
):
    old = write_report(tmp_path, plan, certificate, figures).read_bytes()

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pivotgait.atomic.os.fsync", full)
    with pytest.raises(InputError, match="No space left") as caught:
        write_report(tmp_path, plan, None, figures)
    assert caught.value.exit_code == 2
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.html"]
    assert (tmp_path / "report.html").read_bytes() == old


def test_a_picture_of_unknown_form_is_refused(plan, certificate):
    with pytest.raises(ValueError, match="neither SVG, PNG nor WebP"):
        render_report(plan, certificate, {"hero": Picture(b"GIF89a", alt="", caption="")})
