#!/usr/bin/env python3
"""Check pages, comments and messages against the project's rules of writing, and print what breaks one.

  python3 tests/prose.py [FILE...]        (all pages, and all C and C++ files)

A block is a paragraph, an item of a list, a cell of a table or a comment. A sentence ends at the end of its block, or
at ".", "!" or "?" before a space. A word is anything between spaces that has a letter or a digit; code between
backticks is one word. Headings and code blocks are not sentences. Cells of tables count for the longest sentence, not
for the mean. Texts in quotes are checked for phrases only, and not in tests. A number with a unit and three significant
digits is on two pages only if one of them has a link to the other. unit.pages checks the links.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LONGEST, MEAN = 30, 18  # words
BANNED = {  # what readers stumbled over: what to write instead
    r'anew': 'again',
    r'(?:is|are|was) none\b(?! of)|none that': 'name the thing: missing, invalid, zero',
    r'stands?(?!-)': 'is, appears, stays',
    r'goes by': 'uses',
    r'of which': 'two sentences',
    r'thrice': 'three times',
    r'beyond': 'above, outside, more than',
    r'tells?': 'reports, says',
    r'asks? for': 'requires',
    r'who(?:ever)? wants?': 'to ...',
    r'may be had|can be had': 'is available',
    r'in earnest': 'leave it out',
    r'at its best': 'name the condition',
    r'(?:is|are) no (?!longer|more|less|larger|smaller|faster|slower|worse|better)\w+': 'say what it is, or "is not"',
}
NUMBER = re.compile(r'(?<![\w.^-])\d[\d ]*(?:\.\d+)? (?:%|times|[munk]?[smNJWg]|kN/m|N/m|mJ|GB|MB|KB)(?![\w/])')
OPENING = re.compile(r'(?:What|Who|Whoever|Whatever)\b[^?]*$')  # of a sentence that is not a question


def code_to_word(text):
    text = re.sub(r'``.+?``|`[^`]+`', 'code', text)
    text = re.sub(r'!?\[([^\]]*)\]\([^)]*\)', r'\1', text)
    return re.sub(r'[*_]{2}', '', text)


def sentences(text):
    return [s for s in re.split(r'(?<=[.!?])[)"\']?\s+', code_to_word(text)) if re.search(r'\w', s)]


def words(sentence):
    return sum(1 for word in sentence.split() if re.search(r'\w', word))


def page_blocks(text):
    """Yield (line, text, counts for the mean)."""
    block, start, fenced = [], 0, False
    for number, line in enumerate(text.split('\n') + [''], 1):
        stripped = line.strip()
        fence = stripped.startswith('```')
        starts = re.match(r'(?:[-*]|\d+\.)\s+', stripped)
        if block and (not stripped or fence or fenced or starts or stripped[0] in '#|'):
            yield start, ' '.join(block), True
            block = []
        if fence:
            fenced = not fenced
        elif fenced or not stripped or stripped.startswith('<!--'):
            continue
        elif stripped.startswith('#'):
            yield number, stripped.lstrip('# '), None
        elif stripped.startswith('|'):
            for cell in re.sub(r'`[^`]*`', lambda code: code.group().replace('|', '/'), stripped).strip('|').split('|'):
                if re.search(r'\w', cell):
                    yield number, cell.strip(), False
        else:
            start = start if block else number
            block.append(stripped[starts.end():] if starts else stripped)


def header_blocks(text):
    """Yield (line, text, counts for the mean) of the comments."""
    text = re.sub(r'/\*(.*?)\*/', lambda s: '\n'.join('// ' + line.strip(' *') for line in s[1].split('\n')), text, flags=re.S)
    block, start, column = [], 0, None
    for number, line in enumerate(text.split('\n') + [''], 1):
        found = re.match(r'(.*?)//[/!]?<?(?:\s|$)(.*)', re.sub(r'"(?:[^"\\]|\\.)*"', lambda s: s.group().replace('/', ' '), line))
        at = found.end(1) if found else None
        alone = found and not found.group(1).strip()
        item = found and re.match(r'(?:-|\d+\.|@\w+)\s', found.group(2))
        if block and (not alone or at != column or item or not found.group(2).strip()):
            yield start, ' '.join(block), True
            block = []
        if not found:
            continue
        if not block:
            start, column = number, at
        if found.group(2).strip():
            block.append(found.group(2).strip())


def banned(place, text):
    """Return the lines to print."""
    return [f'{place}: "{match.group()}" ({instead}): {text}' for phrase, instead in BANNED.items()
            if (match := re.search(rf'\b(?:{phrase})\b', text, re.IGNORECASE))]


def check(path):
    """Return the lines to print."""
    text = path.read_text(encoding='utf-8')
    name = path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
    problems, lengths = [], []
    for line, block, counts in (page_blocks if path.suffix == '.md' else header_blocks)(text):
        for sentence in sentences(block):
            length = words(sentence)
            if counts:
                lengths.append(length)
            if counts is not None and length > LONGEST:
                problems.append(f'{name}:{line}: {length} words: {sentence}')
            problems += banned(f'{name}:{line}', sentence)
            if counts and OPENING.match(sentence):
                problems.append(f'{name}:{line}: begins with "{sentence.split()[0]}" (begin with the subject): {sentence}')
    if path.suffix != '.md' and name.parts[0] != 'tests':
        for line, code in enumerate(text.split('\n'), 1):
            for literal in re.findall(r'"((?:[^"\\]|\\.)*)"', re.sub(r'//.*', '', code)):
                problems += banned(f'{name}:{line}', literal)
    if lengths and sum(lengths) > MEAN * len(lengths):
        problems.append(f'{name}: {sum(lengths) / len(lengths):.1f} words a sentence, {MEAN} are allowed')
    return problems


def numbers_on_two_pages(pages):
    """Return the lines to print."""
    problems, seen = [], {}
    for page in pages:
        text = page.read_text(encoding='utf-8')
        links = {(page.parent / link).resolve() for link in re.findall(r'\]\(([^)#]+)', text)}
        for line, block, _ in page_blocks(text):
            for number in NUMBER.findall(code_to_word(block)):
                if len(re.sub(r'\D', '', number).strip('0')) < 3:
                    continue
                for other, other_line, other_links in seen.setdefault(number, []):
                    if page != other and page not in other_links and other not in links:
                        problems.append(f'{page.relative_to(ROOT)}:{line}: {number} is also in '
                                        f'{other.relative_to(ROOT)}:{other_line}: one page has it, the other a link')
                seen[number].append((page, line, links))
    return problems


def main():
    files = [pathlib.Path(name).resolve() for name in sys.argv[1:]]
    if not files:
        folders = [ROOT / folder for folder in ('lib', 'apps', 'plugins', 'data', 'tests')]
        files = sorted(ROOT.glob('*.md')) + [path for folder in folders for path in sorted(folder.glob('**/*.md'))]
        files += [path for folder in folders for path in sorted(folder.glob('**/*'))
                  if path.suffix in ('.h', '.c', '.hpp', '.cpp', '.inl')]
    problems = [problem for path in files for problem in check(path)]
    problems += numbers_on_two_pages([path for path in files if path.suffix == '.md' and path.name != 'CHANGELOG.md'])
    print('\n'.join(problems) if problems else f'{len(files)} files: every sentence follows the rules')
    return 1 if problems else 0


if __name__ == '__main__':
    sys.exit(main())
