"""The pages as routes of the interface, with their style sheet and scripts, and problems as pages."""

from pathlib import Path

from service.api.routes import Routes
from service.pages.page_routes import all_pages
from service.pages.rendering import problem_page

ROUTES = Routes(
    "pages",
    -10,
    guarded=tuple(page.router for page in all_pages() if not page.is_open),
    open=tuple(page.router for page in all_pages() if page.is_open),
    files={"/static": Path(__file__).parent / "static"},
    problem_page=problem_page,
)
