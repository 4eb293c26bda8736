"""Settings of Sphinx; scripts/build_docs.sh calls it with the version of the project."""
import os

project = 'Trunnion'
author = 'the Trunnion authors'
copyright = author
release = version = os.environ.get('TRUNNION_VERSION', '')
html_title = f'Trunnion {release}'.strip()
html_show_copyright = False

extensions = ['myst_parser']
exclude_patterns = ['reference/doxygen-start.md']
myst_heading_anchors = 3
smartquotes = False  # they make one dash of the two before an option

html_theme = 'furo'
html_static_path = ['static']
html_css_files = ['page.css']
# Most blocks without a language are programs, tables and figures: no colours are better than wrong ones.
highlight_language = 'none'
