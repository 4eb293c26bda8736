"""The pages build without a warning of Sphinx or Doxygen, and every link from page to page leads somewhere.

    build_test.py SOURCE_DIR FOLDER     status 77, skipped, where Sphinx, its parts or Doxygen are missing"""
import html.parser
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import urllib.parse

source, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])


class Links(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.targets, self.names = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.names.add(attributes.get('id'))
        for key in ('href', 'src'):
            if attributes.get(key):
                self.targets.append(attributes[key])


def broken_links(pages):
    links = {page: Links(page.read_text()) for page in pages.rglob('*.html') if 'api' not in page.relative_to(pages).parts}
    for page, found in links.items():
        for target in found.targets:
            parts = urllib.parse.urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            file = (page.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else page
            if not file.exists():
                yield f'{page.relative_to(pages)}: {target}: there is no such file'
            elif parts.fragment and file in links and parts.fragment not in links[file].names:
                yield f'{page.relative_to(pages)}: {target}: there is no such place'


missing = [name for name in ('sphinx', 'myst_parser', 'furo') if importlib.util.find_spec(name) is None]
if missing or not shutil.which('doxygen'):
    print('Sphinx, myst-parser, furo and Doxygen are needed: scripts/install_dependencies.sh --docs')
    sys.exit(77)
shutil.rmtree(folder, ignore_errors=True)
built = subprocess.run([source / 'scripts/build_docs.sh', folder], capture_output=True, text=True)
if built.returncode != 0:
    sys.exit(built.stdout + built.stderr)
sys.exit('\n'.join(broken_links((folder / 'html').resolve())) or 0)
