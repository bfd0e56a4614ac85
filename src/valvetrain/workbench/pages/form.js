// The form of a case: groups of fields; a change is sent at once, a refusal stands below its field, the last valid value stays.
export default {
  emits: ["change", "add"],
  props: { groups: Array, additions: Array, open: Array },
  data() { return { texts: {}, refused: {}, typing: {}, wanted: "", opened: {}, awaited: "" }; },
  created() { this.groups.forEach((group) => { this.opened[group.key] = (this.open || []).includes(group.key) && window.innerWidth > 900; }); this.take(); },
  watch: { groups() { this.take(); this.reveal(); } },
  computed: {
    shown() {
      const words = this.wanted.trim().toLowerCase();
      if (!words) { return this.groups; }
      const fits = (field) => (field.label + " " + field.key + " " + field.help).toLowerCase().includes(words);
      return this.groups.map((group) => ({ ...group, fields: group.title.toLowerCase().includes(words) ? group.fields : group.fields.filter(fits) }))
        .filter((group) => group.fields.length);
    },
    found() { return this.shown.reduce((sum, group) => sum + group.fields.length, 0); },
  },
  methods: {
    // What was typed or refused in a table that was removed goes with it.
    take() {
      const keys = new Set(this.groups.flatMap((group) => group.fields.map((field) => field.key)));
      const tables = new Set([...this.groups.map((group) => group.key), ...this.additions.map((one) => one.key)]);
      Object.keys(this.texts).filter((key) => !keys.has(key)).forEach((key) => { delete this.texts[key]; delete this.typing[key]; });
      Object.keys(this.refused).filter((key) => !keys.has(key) && !tables.has(key)).forEach((key) => { delete this.refused[key]; });
      this.groups.forEach((group) => group.fields.forEach((field) => {
        if (!this.refused[field.key] && !this.typing[field.key]) { this.texts[field.key] = field.text; }
      }));
    },
    // What is being typed is never overwritten by an answer to an earlier field.
    type(field, value) { this.typing[field.key] = true; this.texts[field.key] = value; },
    send(field, value) {
      delete this.typing[field.key];
      if (value === field.text && !this.refused[field.key]) { return; }
      if (value === field.text) { this.back(field); return; }
      this.texts[field.key] = value;
      this.$emit("change", { key: field.key, value });
    },
    back(field) { delete this.typing[field.key]; this.texts[field.key] = field.text; delete this.refused[field.key]; },
    answer(key, sentence) {
      if (!sentence) { delete this.refused[key]; return; }
      this.refused[key] = sentence;
      if (this.awaited === key) { this.awaited = ""; }
    },
    add(one) { delete this.refused[one.key]; this.awaited = one.key; this.$emit("add", { key: one.key }); },
    remove(group) { delete this.refused[group.key]; this.$emit("change", { key: group.key, value: "" }); },
    // A table that was added is opened, and its first value is ready to be typed.
    reveal() {
      const group = this.groups.find((one) => one.key === this.awaited);
      if (!this.awaited || !group) { return; }
      this.awaited = "";
      this.seek(group.fields[0].key);
    },
    seek(key) {
      const group = this.groups.find((one) => one.fields.some((field) => field.key === key));
      if (!group) { return; }
      this.opened[group.key] = true;
      this.$nextTick(() => document.getElementById(this.place(key))?.focus());
    },
    place(key) { return "field-" + key.replace(/[^\w]/g, "-"); },
    told(field) {
      const id = this.place(field.key);
      return [field.help || field.limits ? id + "-help" : "", this.refused[field.key] ? id + "-refusal" : ""].filter(Boolean).join(" ") || null;
    },
  },
  template: `
<div class="form">
  <div class="labelled"><label for="find-quantity">Find a quantity</label>
    <input id="find-quantity" type="search" v-model="wanted" autocomplete="off" @keydown.escape="wanted = ''" aria-describedby="found-quantities">
    <p class="hint" id="found-quantities" aria-live="polite">{{ wanted ? (found === 1 ? "1 value" : found + " values") : "" }}</p></div>
  <details v-for="group in shown" :key="group.key" class="group" :open="wanted ? true : opened[group.key]"
    @toggle="wanted || (opened[group.key] = $event.target.open)">
    <summary><span>{{ group.title }}</span><span class="count">{{ group.fields.length }}</span></summary>
    <div class="inside"><div v-for="field in group.fields" :key="field.key" class="field" :data-key="field.key">
      <template v-if="field.kind === 'flag'">
        <label class="check" :for="place(field.key)"><input type="checkbox" :id="place(field.key)" :checked="(texts[field.key] || field.usual) === 'true'"
          :aria-describedby="told(field)" @change="send(field, $event.target.checked ? 'true' : 'false')">{{ field.label }}</label>
      </template>
      <template v-else>
        <div class="top-line"><label :for="place(field.key)">{{ field.label }}</label><span class="unit" v-if="field.unit">{{ field.unit }}</span></div>
        <select v-if="field.kind === 'choice'" :id="place(field.key)" :value="texts[field.key]" :aria-invalid="refused[field.key] ? 'true' : null"
          :aria-describedby="told(field)" @change="send(field, $event.target.value)">
          <option v-if="!field.required" value="">{{ field.usual ? "usual: " + field.usual : "not given" }}</option>
          <option v-for="word in field.choices" :key="word" :value="word">{{ word }}</option>
        </select>
        <textarea v-else-if="field.text.length > 36" :id="place(field.key)" :value="texts[field.key]" autocomplete="off" spellcheck="false" :rows="Math.min(6, Math.ceil(field.text.length / 38))"
          :aria-invalid="refused[field.key] ? 'true' : null" :aria-describedby="told(field)" @input="type(field, $event.target.value)" @change="send(field, $event.target.value)"
          @keydown.enter.prevent="send(field, $event.target.value)" @keydown.escape="back(field)"></textarea>
        <input v-else type="text" :id="place(field.key)" :value="texts[field.key]" autocomplete="off" spellcheck="false" :list="field.choices.length ? place(field.key) + '-list' : null"
          :placeholder="field.usual ? 'usual: ' + field.usual : ''" :required="field.required" :aria-invalid="refused[field.key] ? 'true' : null"
          :aria-describedby="told(field)" @input="type(field, $event.target.value)" @change="send(field, $event.target.value)" @keydown.escape="back(field)">
        <datalist v-if="field.kind !== 'choice' && field.choices.length" :id="place(field.key) + '-list'"><option v-for="word in field.choices" :key="word" :value="word"></option></datalist>
      </template>
      <p v-if="refused[field.key]" class="refusal" :id="place(field.key) + '-refusal'" role="alert">{{ refused[field.key] }}
        <template v-if="field.text">The case keeps {{ field.text }}.</template>
        <button type="button" class="button small" @click="back(field)">Back to it</button></p>
      <p v-if="field.help || field.limits" class="help" :id="place(field.key) + '-help'">{{ [field.help, field.limits].filter(Boolean).join("; ") }}</p>
      <p v-if="field.source" class="source">Source: {{ field.source }}</p>
    </div>
    <button v-if="group.removable" type="button" class="button small" :aria-label="'Remove ' + group.title" @click="remove(group)">Remove this table</button>
    <p v-if="group.removable && refused[group.key]" class="refusal" role="alert">{{ refused[group.key] }}</p></div>
  </details>
  <details v-if="additions.length && !wanted" class="group add">
    <summary><span>Add to the case</span><span class="count">{{ additions.length }}</span></summary>
    <ul class="files inside"><li v-for="one in additions" :key="one.key"><span>{{ one.label }} <small class="hint">{{ one.help }}</small></span>
      <button type="button" class="button small" :aria-label="'Add: ' + one.label" @click="add(one)">Add</button>
      <p v-if="refused[one.key]" class="refusal" role="alert">{{ refused[one.key] }}</p></li></ul>
  </details>
</div>`,
};
