// How a job stands: share done, time left, cancel; the sentence where it ended otherwise than well.
export default {
  emits: ["cancel", "again"],
  props: { job: Object },
  template: `
<p v-if="job && job.state === 'finished'" class="off-screen" role="status" data-state="finished">{{ job.title }} finished</p>
<div v-else-if="job" class="panel job" :data-state="job.state">
  <div class="split"><h2>{{ job.title }}</h2><span class="state" :class="job.tone">{{ job.state }}</span></div>
  <template v-if="job.going">
    <label class="off-screen" :for="'progress-' + job.id">Share done</label>
    <progress :id="'progress-' + job.id" max="100" :value="job.percent">{{ job.percent }} %</progress>
    <div class="split"><span class="said" role="status">{{ job.words }}</span>
      <button type="button" class="button stop small" @click="$emit('cancel')">Cancel</button></div>
  </template>
  <template v-else>
    <p v-if="job.words" class="said" :class="job.tone" role="status">{{ job.words }}</p>
    <div class="row"><button v-if="job.again" type="button" class="button small" @click="$emit('again')">Run it again</button></div>
  </template>
</div>`,
};
