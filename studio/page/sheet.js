// The form of the data sheet, which makes a machine file.

/** An item's field, with its label. */
function fieldOf(question) {
  const input = element('input', { name: question.flag, placeholder: question.example });
  const need = question.otherwise ? `without it: ${question.otherwise}` : question.need;
  const label = element('label', {}, question.what, element('span', { className: 'soft', textContent: need }), input);
  return { question, input, label };
}

/** Takes the machine file of a filled form as the drive. */
async function makeMachine(form) {
  Object.assign(drive, { name: 'machine.toml', text: await engine.call('machine_of_sheet', [JSON.stringify(form)]) });
  byId('text').open = true;
  await writeMaps();
}

/** The form, from the table of `host-sim init`. */
function showForm() {
  const source = element('select', { ariaLabel: 'What feeds the cylinder' },
    element('option', { value: 'of_valve', textContent: 'a servo or proportional valve' }),
    element('option', { value: 'of_pump', textContent: 'a pump, directly' }));
  const called = element('input', { placeholder: 'press' });
  const over = element('input', { type: 'checkbox' });
  const told = element('p', { className: 'problem' });
  const fields = engine.questions.map(fieldOf);
  const choose = () => fields.forEach(({ question, label }) => { label.hidden = label.style.display = question[source.value] ? '' : 'none'; });
  source.onchange = choose;
  choose();
  byId('form').replaceChildren(
    element('p', {}, element('label', {}, 'What feeds the cylinder? ', source)),
    element('div', { className: 'fields' }, element('label', {}, 'Name of the drive', called), ...fields.map(({ label }) => label)),
    element('p', {}, element('label', {}, over, ' The rated pressure drop stands over both edges in series')),
    element('p', {}, element('button', { textContent: 'Make the machine file' })), told);
  byId('form').onsubmit = async (event) => {
    event.preventDefault();
    refuse();
    told.textContent = '';
    const given = fields.filter(({ question }) => question[source.value]).map(({ input }) => [input.name, input.value]);
    const name = called.value.trim() || called.placeholder;
    try {
      await makeMachine({ name, over_both_edges: over.checked, answers: Object.fromEntries(given) });
    } catch (error) {
      told.textContent = error.message;
    }
  };
}
