// Elements of the page.
const byId = (id) => document.getElementById(id);

/** A new element; texts are texts, never markup. */
function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children.filter((child) => child != null));
  return made;
}

/** A table with a heading. */
function table(headings, rows) {
  const head = element('tr', {}, ...headings.map((text) => element('th', { textContent: text })));
  return element('table', {}, element('thead', {}, head), element('tbody', {}, ...rows));
}

/** Lets the browser save a text. */
function save(name, type, text) {
  const address = URL.createObjectURL(new Blob([text], { type }));
  element('a', { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

const problem = byId('refused');
/** Says what could not be done; nothing where there is no text. */
function refuse(text) {
  problem.textContent = text ?? '';
  problem.hidden = !text;
}
