// Pages for users first: the guide and public names before modules and measurements.
const behind = /^(reference\/generated|measured_|tested_|benchmarks|changelog|contributing)/;
const first = /^(learn|getting_started|tutorial|walls|adhesion|cheat_sheet|microscope|solids|accuracy)/;
const member = /^Python (method|property|attribute|data)/;
const query = new URLSearchParams(location.search).get("q")?.trim().toLowerCase();

Scorer = {
  score: ([docname, title, , descr, score]) => {
    if (behind.test(docname)) return score / 10;
    if (docname.startsWith("reference/names/")) return score + (member.test(descr) ? -6 : 8);
    // A heading that begins with what was asked for
    const heading = title.split(" > ").pop().toLowerCase();
    return score + (first.test(docname) ? 4 : 0) + (heading.startsWith(query) ? 10 : 0);
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
