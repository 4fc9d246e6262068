// Pages for users first: public names and the guide before modules and measurements.
const behind = /^(reference\/generated|measured_|tested_|benchmarks|changelog)/;
const first = /^(learn|getting_started|tutorial|walls|adhesion|cheat_sheet|microscope|solids|accuracy)/;

Scorer = {
  score: ([docname, , , , score]) =>
    behind.test(docname)
      ? score / 10
      : score + (docname.startsWith("reference/names/") ? 8 : first.test(docname) ? 4 : 0),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
