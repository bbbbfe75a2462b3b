#!/bin/sh
# What a repository tells its visitors: the files are there, the citation has this version, the paper has the sections
# and the length that the journal asks for, and what it cites.
. tests/lib/script.sh

for file in LICENSE CITATION.cff .github/CONTRIBUTING.md .github/CODE_OF_CONDUCT.md .github/SECURITY.md \
            .github/PULL_REQUEST_TEMPLATE.md .github/ISSUE_TEMPLATE/bug.md docs/paper/paper.md docs/paper/paper.bib; do
    check "$file" [ -s "$file" ]
done

version=$(sed -n 's/^#define PD_VERSION "\(.*\)"/\1/p' pdcorr.h | head -n 1)
[ "$version" ] || version=$(sed -n '1s/.*pdcorr \([0-9.]*\):.*/\1/p' pdcorr.h)
check "CITATION.cff has the version $version" grep -qx "version: $version" CITATION.cff
for key in cff-version message title authors license type; do
    check "CITATION.cff has $key" [ "$(grep -c "^$key:" CITATION.cff)" = 1 ]
done
if /usr/bin/python3 -c 'import yaml' 2> /dev/null; then
    /usr/bin/python3 - > "$dir/log" 2>&1 << 'END'
import re
import yaml

citation = yaml.safe_load(open("CITATION.cff", encoding="utf-8"))
assert citation["cff-version"] == "1.2.0" and citation["license"] == "MIT", citation
person = {"name", "given-names", "family-names", "orcid", "affiliation"}
assert all(set(author) <= person for author in citation["authors"])
head, text = re.match(r"---\n(.*?)\n---\n(.*)", open("docs/paper/paper.md", encoding="utf-8").read(), re.S).groups()
paper = yaml.safe_load(head)
assert {"title", "tags", "authors", "affiliations", "date", "bibliography"} <= set(paper), paper
assert [a["name"] for a in paper["authors"]] == [a["name"] for a in citation["authors"]]
for form in ("bug", "physics"):
    front = open(f".github/ISSUE_TEMPLATE/{form}.md", encoding="utf-8").read().split("---\n")[1]
    assert {"name", "about"} <= set(yaml.safe_load(front)), form
yaml.safe_load(open(".github/ISSUE_TEMPLATE/config.yml", encoding="utf-8"))
END
    verdict "heads of citation, paper and forms"
else
    echo "skipped: yaml for Python is not installed: heads of citation, paper and forms"
    skipped=$((skipped + 1))
fi

printf '# %s\n' Summary "Statement of need" "State of the field" "Software design" "Research impact statement" \
    "AI usage disclosure" Acknowledgements References > "$dir/wanted"
sed '1,/^---$/{/^---$/!d}' docs/paper/paper.md | grep '^# ' > "$dir/found"
diff "$dir/wanted" "$dir/found" > "$dir/log"
verdict "sections of the paper"
words=$(sed '1d' docs/paper/paper.md | sed '1,/^---$/d; s/<!--[^>]*-->//g' | wc -w)
check "the paper has 750 to 1750 words: $words" [ "$words" -ge 750 -a "$words" -le 1750 ]
grep -o '@[A-Z][A-Za-z0-9]*' docs/paper/paper.md | sort -u > "$dir/cited"
sed -n 's/^@[a-z]*{\(.*\),$/@\1/p' docs/paper/paper.bib | sort > "$dir/listed"
diff "$dir/cited" "$dir/listed" > "$dir/log"
verdict "what the paper cites is what paper.bib lists"
score
